"""The compiler of the WebAssembly module: numba's LLVM has the back end, and nothing links.

It runs in a process whose numba compiles for a generic processor; see `motionlab.targets.wasm`.
"""

from __future__ import annotations

import functools
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numba
from numba import int64, types

import motionlab.lanes.compiler  # noqa: F401 - numba learns the lanes' types
from motionlab.kernel.accumulator import Tally
from motionlab.kernel.layout import PARAMETERS, STATES, Inputs
from motionlab.lanes import module_hash
from motionlab.loop.family import VELOCITIES
from motionlab.loop.linearise import QUOTIENT
from motionlab.targets.wasm_exports import EXPORTS, LANES, LOOP_BYTES, Block, Export
from motionlab.targets.wasm_laws import quotients
from motionlab.targets.wasm_math import FUNCTIONS
from motionlab.targets.wasm_module import module_of, with_custom_section
from motionlab.telemetry.channels import CHANNELS
from motionlab.timing import CONTROL_PERIOD

TRIPLE = "wasm32-unknown-unknown"
FEATURES = "+simd128"
SECTION = "motionlab"
"""Name of the custom section with what a page must know of a module, in JSON."""

_OPTIMISATION = 3


def description() -> dict[str, Any]:
    """Return what a page must know of the module: rows, a hash of its sources, parameters."""
    return {
        "module": module_hash(),
        "control_period": CONTROL_PERIOD,
        "lanes": LANES,
        "parameters": PARAMETERS,
        "state": STATES,
        "inputs": Inputs._fields,
        "channels": [channel.name for channel in CHANNELS],
        "tally": Tally._fields,
        "loops": {"speeds": VELOCITIES, "blocks": LOOP_BYTES},
        "quotients": {"laws": quotients(), "message": QUOTIENT},
        "exports": {each.function.__name__: _names(each) for each in EXPORTS},
    }


def compile_module() -> bytes:
    """Return the module, compiled by this process."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple(TRIPLE)
    machine = target.create_target_machine(cpu="generic", features=FEATURES, opt=_OPTIMISATION)
    whole = llvm.parse_assembly("")
    for export in EXPORTS:
        whole.link_in(_compiled(export, machine))
    for function, parameters in FUNCTIONS.items():
        whole.link_in(_library_function(function, parameters, machine))
    names = [export.function.__name__ for export in EXPORTS]
    module = module_of(machine.emit_object(whole), names)
    return with_custom_section(module, SECTION, json.dumps(description()).encode())


def _compiled(export: Export, machine: Any) -> Any:
    """Return an export as LLVM's module for the machine, in which nothing else is visible."""
    signature = types.void(*(_type(each) for each in export.parameters))
    entry = functools.partial(_entry, export)
    return _module(export.function, signature, entry, machine, small=export.small)


def _library_function(function: Any, parameters: int, machine: Any) -> Any:
    """Return a function on numbers as LLVM's module, called by its name as in the C library."""
    doubles = ", ".join(f"double %x{k}" for k in range(parameters))

    def entry(inner: str) -> str:
        kinds = ", ".join(["double"] * parameters)
        return f"""
declare i32 @"{inner}"(ptr, ptr, {kinds})

define double @{function.__name__}({doubles}) {{
  %result = alloca double
  %exception = alloca ptr
  %status = call i32 @"{inner}"(ptr %result, ptr %exception, {doubles})
  %value = load double, ptr %result
  ret double %value
}}
"""

    signature = types.float64(*[types.float64] * parameters)
    return _module(function, signature, entry, machine, small=True)


def _module(
    function: Any,
    signature: Any,
    entry: Callable[[str], str],
    machine: Any,
    *,
    small: bool = False,
) -> Any:
    """Return a function as LLVM's module, of which only the entry of its name is visible."""
    options = {"error_model": "numpy", "_nrt": False}  # arrays belong to the page
    dispatcher: Any = numba.njit([signature], **options)(function)
    (overload,) = dispatcher.overloads.values()
    name, inner = function.__name__, overload.fndesc.llvm_func_name
    code = overload.library.get_llvm_str()
    # numba compiles for this machine's memory layout, which is no part of what the code does.
    for key, value in (("datalayout", machine.target_data), ("triple", machine.triple)):
        code = re.sub(f"^target {key} = .*$", f'target {key} = "{value}"', code, flags=re.M)
    module = llvm.parse_assembly(code)
    module.link_in(llvm.parse_assembly(entry(inner)))
    for each in module.functions:
        if each.name != name and not each.is_declaration:
            each.linkage = "internal"
            each.add_function_attribute("alwaysinline")  # calls with results need a stack
    for variable in module.global_variables:
        variable.linkage = "internal"
    tuning = llvm.create_pipeline_tuning_options(speed_level=_OPTIMISATION)
    if small:
        tuning.loop_vectorization = tuning.slp_vectorization = tuning.loop_unrolling = False
        for each in module.functions:
            if not each.is_declaration:
                each.add_function_attribute("optsize")
    passes = llvm.create_pass_builder(machine, tuning)
    passes.getModulePassManager().run(module, passes)
    return module


def _type(parameter: Block | str) -> Any:
    if isinstance(parameter, str):
        return int64
    layout = "C" if parameter.strides is None else "A"
    return types.Array(parameter.element, len(parameter.shape), layout)


def _names(export: Export) -> list[str]:
    """Return the parameters of an export in the module: its own, then sizes in order of mention."""
    names = [each if isinstance(each, str) else each.name for each in export.parameters]
    for each in export.parameters:
        if isinstance(each, Block):
            names += [
                size for size in (*each.shape, *(each.strides or ())) if isinstance(size, str)
            ]
    return list(dict.fromkeys(names))


def _entry(export: Export, inner: str) -> str:
    """Return LLVM assembly of a function that calls numba's with arrays made from pointers."""
    blocks = {each.name for each in export.parameters if isinstance(each, Block)}
    names = _names(export)
    parameters = ", ".join(f"{'ptr' if name in blocks else 'i32'} %{name}" for name in names)
    lines = [f"%{name}.long = zext i32 %{name} to i64" for name in names if name not in blocks]
    arguments = ["ptr %result", "ptr %exception"]
    for each in export.parameters:
        arguments += [f"i64 %{each}.long"] if isinstance(each, str) else _array(each, lines)
    kinds = ", ".join(argument.split()[0] for argument in arguments)
    body = "\n  ".join(lines)
    return f"""
declare i32 @"{inner}"({kinds})

define void @{export.function.__name__}({parameters}) {{
  %result = alloca ptr
  %exception = alloca ptr
  {body}
  %status = call i32 @"{inner}"({", ".join(arguments)})
  ret void
}}
"""


def _array(block: Block, lines: list[str]) -> list[str]:
    """Return the fields of numba's array of a block; what they need is added to `lines`."""
    bytes_each = block.element.bitwidth // 8
    sizes = [_long(size) for size in block.shape]
    strides = block.strides
    if strides is None:
        strides, inner = (), 1
        for size in reversed(block.shape):
            strides = (inner, *strides)
            inner = inner * size if isinstance(size, int) else 0
    in_bytes = []
    for stride in strides:
        if isinstance(stride, int):
            in_bytes.append(f"i64 {stride * bytes_each}")
        else:
            lines.append(f"%{block.name}.{stride} = mul i64 %{stride}.long, {bytes_each}")
            in_bytes.append(f"i64 %{block.name}.{stride}")
    owner = ["ptr null", "ptr null"]
    return [*owner, "i64 0", f"i64 {bytes_each}", f"ptr %{block.name}", *sizes, *in_bytes]


def _long(size: int | str) -> str:
    return f"i64 {size}" if isinstance(size, int) else f"i64 %{size}.long"


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(compile_module())
