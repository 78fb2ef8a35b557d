"""The kernels of the simulation for the loop to call: the same machine code, at its address.

Else numba would compile a kernel once more into each function that calls it, and might round
otherwise there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
from llvmlite import binding
from numba.core import cgutils, types
from numba.extending import intrinsic

from motionlab.kernel.law_calls import all_laws
from motionlab.kernel.tick import run_lanes

_numba: Any = numba  # whose types do not name all that it exports
_numbers: Any = types.float64
_samples: Any = types.float32


def _kernel(name: str, tables: Any) -> Callable[..., None]:
    """Return `run_lanes` for one type of tables, under a symbol that cached code knows it by."""
    if _numba.config.DISABLE_JIT:
        return run_lanes
    compiled: Any = run_lanes
    arrays = (_numbers[:, ::1], _numbers[:, ::1], _numbers[:, :, ::1], _samples[:, :, ::1], tables)
    taken = (*arrays, _numba.typeof(all_laws()))
    compiled.compile(taken)
    overload = compiled.overloads[taken]
    address = overload.library.get_pointer_to_function(overload.fndesc.llvm_func_name)
    # Cached code refers to the name: the address is another in each process.
    binding.add_symbol(name, address)

    @intrinsic
    def call(  # noqa: PLR0913, PLR0917 - as `run_lanes`
        _: Any, parameters: Any, state: Any, inputs: Any, samples: Any, tables: Any, laws: Any
    ) -> Any:
        signature = types.void(*taken)

        def lower(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            convention = context.call_conv
            kind = convention.get_function_type(signature.return_type, signature.args)
            function = cgutils.get_or_insert_function(builder.module, kind, name)
            convention.call_function(
                builder, function, signature.return_type, signature.args, values
            )
            return context.get_dummy_value()

        return signature, lower

    return call


run_plain = _kernel("motionlab_run_lanes", types.none)
"""`run_lanes` of lanes without tables."""
run_tabled = _kernel("motionlab_run_lanes_with_tables", _numbers[::1])
"""`run_lanes` of lanes with tables."""
