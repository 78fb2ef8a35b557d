"""The floating-point mode of compiled code: subnormal numbers count as zero.

A current that decays towards zero, or a mover that comes to rest, would end in subnormal numbers,
which cost many times as much as others. They are far below anything physical.
"""

from __future__ import annotations

import platform
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.extending import type_callable

from motionlab.lanes.compiler.vector import i32
from motionlab.lanes.operations import flush_subnormals, restore_mode

_HAS_MXCSR = platform.machine().lower() in {"x86_64", "amd64"}
_FLUSH = 0x8040  # flush results to zero, take operands as zero


@type_callable(flush_subnormals)
def _type_flush_subnormals(context: Any) -> Any:
    return lambda: types.int32


@type_callable(restore_mode)
def _type_restore_mode(context: Any) -> Any:
    return lambda mode: types.none


def _mode_call(builder: Any, name: str, slot: Any) -> None:
    word = ir.IntType(8).as_pointer()
    kind = ir.FunctionType(ir.VoidType(), [word])
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.x86.sse.{name}")
    builder.call(function, [builder.bitcast(slot, word)])


@lower_builtin(flush_subnormals)
def _lower_flush_subnormals(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    if not _HAS_MXCSR:
        return i32(0)
    slot = cgutils.alloca_once(builder, ir.IntType(32))
    _mode_call(builder, "stmxcsr", slot)
    mode = builder.load(slot)
    builder.store(builder.or_(mode, i32(_FLUSH)), slot)
    _mode_call(builder, "ldmxcsr", slot)
    return mode


@lower_builtin(restore_mode, types.Integer)
def _lower_restore_mode(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    if _HAS_MXCSR:
        slot = cgutils.alloca_once(builder, ir.IntType(32))
        builder.store(context.cast(builder, args[0], sig.args[0], types.int32), slot)
        _mode_call(builder, "ldmxcsr", slot)
    return context.get_dummy_value()
