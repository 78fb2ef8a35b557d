"""The SIMD lane type: eight or sixteen doubles that compiled code treats as one number.

A *lane* is one axis of one controller of one run. The model is written once, as if for a single
lane, with ``+ - * /``, comparisons, and the few functions below; where it branches it selects.
Compiled by numba a value is one LLVM vector ``<8 x double>``, so that the vector unit is used by
construction and a lane's bits cannot depend on what its neighbours do. With
``NUMBA_DISABLE_JIT=1`` the same code runs on numpy arrays of shape (8,), which is how the tests
check one against the other. Batches use sixteen lanes, two such vectors side by side: twice the
lanes wait for the same chain of operations, and each vector's code, so each lane's bits, stays
what it is alone. A vector of sixteen would not do: of two products that may be fused with their
sum, LLVM picks another one there.

The floating-point liberties taken are fused multiply-add, reciprocals of shared divisors, and the
sign of zero. numba's ``fastmath=True`` would fold ``isfinite`` to True and let NaN pass unseen.
"""

from __future__ import annotations

import functools
import operator
import platform
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import models, register_model, type_callable

WIDTH = 8
"""Lanes in one vector: of a single run."""

WIDE = 16
"""Lanes of a batch: two vectors side by side."""

_FLAGS = ("contract", "arcp", "nsz")
_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_SINGLE = ir.VectorType(ir.FloatType(), WIDTH)
_BITS = ir.VectorType(ir.IntType(64), WIDTH)
_MASK = ir.VectorType(ir.IntType(1), WIDTH)
_PAIR = ir.VectorType(ir.DoubleType(), 2)
_ALIGN = 8  # numpy promises no more than the alignment of one double


class LanesType(types.Type):
    """numba's type of `width` doubles side by side."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Lanes{width}")


class MaskType(types.Type):
    """numba's type of `width` truth values side by side."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Mask{width}")


def _side_by_side(vector: Any, width: int) -> Any:
    """Return LLVM's type of `width` lanes: one vector, or an array of them."""
    return vector if width == WIDTH else ir.ArrayType(vector, width // WIDTH)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _side_by_side(_VECTOR, fe_type.width))


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _side_by_side(_MASK, fe_type.width))


def _is_lanes(ty: Any) -> bool:
    return isinstance(ty, LanesType)


def _is_number(ty: Any) -> bool:
    return isinstance(ty, types.Float | types.Integer | types.IntegerLiteral)


def _width(args: Any) -> int | None:
    """Return how wide lanes among lanes and numbers are; None where they do not go together."""
    widths = {arg.width for arg in args if _is_lanes(arg)}
    fits = len(widths) == 1 and all(_is_lanes(arg) or _is_number(arg) for arg in args)
    return widths.pop() if fits else None


def split_vectors(context: Any, builder: Any, value: Any, ty: Any, width: int) -> list[Any]:
    """Return `value` vector by vector, repeating a scalar in every lane."""
    count = width // WIDTH
    if _is_number(ty):
        scalar = context.cast(builder, value, ty, types.float64)
        return [_repeat(builder, scalar, _VECTOR)] * count
    if count == 1:
        return [value]
    return [builder.extract_value(value, i) for i in range(count)]


def join_vectors(builder: Any, vectors: list[Any]) -> Any:
    """Return vectors side by side as one value."""
    if len(vectors) == 1:
        return vectors[0]
    value = ir.Constant(ir.ArrayType(vectors[0].type, len(vectors)), ir.Undefined)
    for i, vector in enumerate(vectors):
        value = builder.insert_value(value, vector, i)
    return value


def _emit_each(emit: Any, context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Return what `emit` gives of the arguments, vector by vector."""
    width = sig.return_type.width
    pairs = zip(args, sig.args, strict=True)
    split = [split_vectors(context, builder, value, ty, width) for value, ty in pairs]
    return join_vectors(builder, [emit(builder, *some) for some in zip(*split, strict=True)])


def _repeat(builder: Any, scalar: Any, vector_type: Any) -> Any:
    one = builder.insert_element(ir.Constant(vector_type, ir.Undefined), scalar, _i32(0))
    order = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, ir.Constant(vector_type, ir.Undefined), order)


def _i32(value: int) -> Any:
    return ir.Constant(ir.IntType(32), value)


# -- operators ------------------------------------------------------------------------------------


def _register_operator(op: Any, emit: Any, *, result: Any, arity: int = 2) -> None:
    """Teach numba that `op` works lane by lane, with scalars repeated."""

    @infer_global(op)  # pyright: ignore[reportOptionalCall]
    class _Operator(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            width = _width(args) if len(args) == arity else None
            return None if width is None else signature(result(width), *args)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _emit_each(emit, context, builder, sig, args)

    scalars = (types.Float, types.Integer, types.IntegerLiteral)
    lower_builtin(op, *[LanesType] * arity)(lower)
    if arity == 2:
        for scalar in scalars:
            lower_builtin(op, LanesType, scalar)(lower)
            lower_builtin(op, scalar, LanesType)(lower)


def _intrinsic(name: str) -> Any:
    def emit(builder: Any, *args: Any) -> Any:
        kind = ir.FunctionType(_VECTOR, [_VECTOR] * len(args))
        full_name = f"{name}.v{WIDTH}f64"
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, full_name), args)

    return emit


def _comparison(condition: str) -> Any:
    return lambda builder, a, b: builder.fcmp_ordered(condition, a, b)


for _op, _emit in (
    (operator.add, lambda builder, a, b: builder.fadd(a, b, flags=_FLAGS)),
    (operator.sub, lambda builder, a, b: builder.fsub(a, b, flags=_FLAGS)),
    (operator.mul, lambda builder, a, b: builder.fmul(a, b, flags=_FLAGS)),
    (operator.truediv, lambda builder, a, b: builder.fdiv(a, b, flags=_FLAGS)),
):
    _register_operator(_op, _emit, result=LanesType)
for _op, _condition in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _register_operator(_op, _comparison(_condition), result=MaskType)
_register_operator(operator.neg, lambda builder, a: builder.fneg(a), result=LanesType, arity=1)
_register_operator(abs, _intrinsic("llvm.fabs"), result=LanesType, arity=1)


def _register_mask_operator(op: Any, emit: Any, arity: int) -> None:
    @infer_global(op)  # pyright: ignore[reportOptionalCall]
    class _MaskOperator(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            same = len(args) == arity and isinstance(args[0], MaskType) and len(set(args)) == 1
            return signature(args[0], *args) if same else None

    lower_builtin(op, *[MaskType] * arity)(functools.partial(_emit_each, emit))


_register_mask_operator(operator.and_, lambda builder, a, b: builder.and_(a, b), 2)
_register_mask_operator(operator.or_, lambda builder, a, b: builder.or_(a, b), 2)
_register_mask_operator(operator.invert, lambda builder, a: builder.not_(a), 1)


# -- functions ------------------------------------------------------------------------------------
# Each is a plain Python function on arrays, and a typed, lowered one for compiled code.


def select(mask: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where `mask` holds and `no` elsewhere."""
    return np.where(mask, yes, no)


@type_callable(select)
def _type_select(context: Any) -> Any:
    def typer(mask: Any, yes: Any, no: Any) -> Any:
        if not isinstance(mask, MaskType):
            return None
        lanes = LanesType(mask.width)
        return lanes if _width((lanes, yes, no)) == mask.width else None

    return typer


@lower_builtin(select, MaskType, types.Any, types.Any)
def _lower_select(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _emit_each(
        lambda builder, mask, yes, no: builder.select(mask, yes, no), context, builder, sig, args
    )


def _register_unary(function: Any, emit: Any) -> None:
    @type_callable(function)
    def _type(context: Any) -> Any:
        return lambda x: x if _is_lanes(x) else None

    lower_builtin(function, LanesType)(functools.partial(_emit_each, emit))


def square_root(x: Any) -> Any:
    """Return the square root of `x`."""
    return np.sqrt(x)


def round_down(x: Any) -> Any:
    """Return the greatest whole number not above `x`."""
    return np.floor(x)


def round_nearest(x: Any) -> Any:
    """Return the whole number nearest to `x`, halves to even."""
    return np.rint(x)


def power_of_two(n: Any) -> Any:
    """Return 2**n for whole `n` with -1022 <= n <= 1023."""
    return np.ldexp(1.0, n.astype(np.int64))


def _emit_power_of_two(builder: Any, n: Any) -> Any:
    # Adding 1.5 * 2**52 leaves n + bias in the low bits of the mantissa; shifted by 52 they are
    # the exponent. AVX2 has no conversion from double to 64-bit integer, this needs none.
    shifted = builder.fadd(n, ir.Constant(_VECTOR, [1.5 * 2.0**52 + 1023.0] * WIDTH))
    bits = builder.shl(builder.bitcast(shifted, _BITS), ir.Constant(_BITS, [52] * WIDTH))
    return builder.bitcast(bits, _VECTOR)


_register_unary(square_root, _intrinsic("llvm.sqrt"))
_register_unary(round_down, _intrinsic("llvm.floor"))
_register_unary(round_nearest, _intrinsic("llvm.rint"))
_register_unary(power_of_two, _emit_power_of_two)


# -- memory ---------------------------------------------------------------------------------------
# How wide the lanes of an array are its type does not say: what reads one is told, by a constant or
# by lanes that are as wide.


def _row(  # noqa: PLR0913, PLR0917 - numba's lowering, an array, where in it
    context: Any, builder: Any, array_type: Any, array: Any, row: Any, width: int
) -> list[Any]:
    """Return the addresses of the vectors of ``array.flat[row * width :]``, C-contiguous."""
    data = context.make_array(array_type)(context, builder, array).data
    first = builder.mul(row, _i64(width))
    at = [builder.gep(data, [builder.add(first, _i64(i))]) for i in range(0, width, WIDTH)]
    vector = _SINGLE if array_type.dtype == types.float32 else _VECTOR
    return [builder.bitcast(address, vector.as_pointer()) for address in at]


def _load_rows(context: Any, builder: Any, sig: Any, args: Any, first: Any) -> Any:
    """Return rows of an array from `first` on as a named tuple of lanes."""
    count, width = sig.return_type.count, sig.return_type.dtype.width
    array_type, array = sig.args[1], args[1]
    single = array_type.dtype == types.float32
    values = []
    for i in range(count):
        at = _row(context, builder, array_type, array, builder.add(first, _i64(i)), width)
        vectors = [builder.load(address, align=_ALIGN // 2) for address in at]
        if single:
            vectors = [builder.fpext(vector, _VECTOR) for vector in vectors]
        values.append(join_vectors(builder, vectors))
    return context.make_tuple(builder, sig.return_type, values)


def _i64(value: int) -> Any:
    return ir.Constant(ir.IntType(64), value)


def _register_reader(function: Any) -> None:
    """Teach numba that `function` returns a named tuple of lanes, as wide as a constant says."""

    @infer_global(function)  # pyright: ignore[reportOptionalCall]
    class _Reader(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            record, _, _, *width = args
            lanes = LanesType(WIDTH)
            if width and isinstance(width[0], LanesType):
                lanes = width[0]
            elif width and not isinstance(width[0], types.IntegerLiteral):
                return None  # numba comes again with the constant
            elif width:
                lanes = LanesType(width[0].literal_value)
            cls = record.instance_class
            return signature(types.NamedUniTuple(lanes, len(cls._fields), cls), *args)


def unpack(record: Any, array: Any, first: int = 0, width: Any = WIDTH) -> Any:
    """Return rows `first`, ... of `array`, shape (rows, width), as a named tuple of lanes."""
    return record(*array[first : first + len(record._fields)])


_register_reader(unpack)


@lower_builtin(unpack, types.NamedTupleClass, types.Array, types.Integer)
@lower_builtin(unpack, types.NamedTupleClass, types.Array, types.Integer, types.Any)
def _lower_unpack(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    first = context.cast(builder, args[2], sig.args[2], types.int64)
    return _load_rows(context, builder, sig, args, first)


def axes_at(record: Any, array: Any, tick: Any, width: Any = WIDTH) -> Any:
    """Return ``array[tick]``, shape (fields, 2), as a named tuple: x in even lanes, y in odd."""
    return record(*np.tile(array[tick], (width if isinstance(width, int) else len(width)) // 2))


_register_reader(axes_at)


@lower_builtin(axes_at, types.NamedTupleClass, types.Array, types.Integer)
@lower_builtin(axes_at, types.NamedTupleClass, types.Array, types.Integer, types.Any)
def _lower_axes_at(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    count, width = sig.return_type.count, sig.return_type.dtype.width
    tick = context.cast(builder, args[2], sig.args[2], types.int64)
    data = context.make_array(sig.args[1])(context, builder, args[1]).data
    data = builder.gep(data, [builder.mul(tick, _i64(2 * count))])
    order = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0, 1] * (WIDTH // 2))
    fields = []
    for i in range(count):
        address = builder.bitcast(builder.gep(data, [_i64(2 * i)]), _PAIR.as_pointer())
        pair = builder.load(address, align=_ALIGN)
        vector = builder.shuffle_vector(pair, ir.Constant(_PAIR, ir.Undefined), order)
        fields.append(join_vectors(builder, [vector] * (width // WIDTH)))
    return context.make_tuple(builder, sig.return_type, fields)


def pack(values: Any, array: Any) -> None:
    """Write a named tuple of lanes into the rows of `array`, shape (fields, width)."""
    for row, value in zip(array, values, strict=True):
        row[:] = value


def record(values: Any, array: Any, tick: Any) -> None:
    """Write a named tuple of lanes into ``array[tick]``, in the array's own precision."""
    pack(values, array[tick])


def recorded(record: Any, array: Any, tick: Any, width: Any = WIDTH) -> Any:
    """Return ``array[tick]``, shape (fields, width), in single precision, as lanes."""
    return record(*array[tick].astype(np.float64))


@type_callable(pack)
def _type_pack(context: Any) -> Any:
    return lambda values, array: types.none


@type_callable(record)
def _type_record(context: Any) -> Any:
    return lambda values, array, tick: types.none


_register_reader(recorded)


def _store_rows(context: Any, builder: Any, sig: Any, args: Any, first: Any) -> Any:
    lanes, array_type = sig.args[0].dtype, sig.args[1]
    single = array_type.dtype == types.float32
    for i in range(sig.args[0].count):
        value = builder.extract_value(args[0], i)
        vectors = split_vectors(context, builder, value, lanes, lanes.width)
        row = builder.add(first, _i64(i))
        at = _row(context, builder, array_type, args[1], row, lanes.width)
        for vector, address in zip(vectors, at, strict=True):
            stored = builder.fptrunc(vector, _SINGLE) if single else vector
            builder.store(stored, address, align=_ALIGN // 2)
    return context.get_dummy_value()


@lower_builtin(pack, types.NamedUniTuple, types.Array)
def _lower_pack(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _store_rows(context, builder, sig, args, _i64(0))


@lower_builtin(record, types.NamedUniTuple, types.Array, types.Integer)
def _lower_record(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    tick = context.cast(builder, args[2], sig.args[2], types.int64)
    return _store_rows(context, builder, sig, args, builder.mul(tick, _i64(sig.args[0].count)))


@lower_builtin(recorded, types.NamedTupleClass, types.Array, types.Integer)
@lower_builtin(recorded, types.NamedTupleClass, types.Array, types.Integer, types.Any)
def _lower_recorded(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    tick = context.cast(builder, args[2], sig.args[2], types.int64)
    return _load_rows(context, builder, sig, args, builder.mul(tick, _i64(sig.return_type.count)))


# -- rounding mode --------------------------------------------------------------------------------
# A current that decays towards zero, or a mover that comes to rest, would end in subnormal numbers,
# which cost many times as much as others. They are far below anything physical.

_HAS_MXCSR = platform.machine().lower() in {"x86_64", "amd64"}
_FLUSH = 0x8040  # flush results to zero, take operands as zero


def flush_subnormals() -> int:
    """Let subnormal numbers count as zero in this thread; return what `restore_mode` takes."""
    return 0


def restore_mode(mode: int) -> None:
    """Restore the floating-point mode that flush_subnormals returned."""


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
        return _i32(0)
    slot = cgutils.alloca_once(builder, ir.IntType(32))
    _mode_call(builder, "stmxcsr", slot)
    mode = builder.load(slot)
    builder.store(builder.or_(mode, _i32(_FLUSH)), slot)
    _mode_call(builder, "ldmxcsr", slot)
    return mode


@lower_builtin(restore_mode, types.Integer)
def _lower_restore_mode(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    if _HAS_MXCSR:
        slot = cgutils.alloca_once(builder, ir.IntType(32))
        builder.store(context.cast(builder, args[0], sig.args[0], types.int32), slot)
        _mode_call(builder, "ldmxcsr", slot)
    return context.get_dummy_value()


__all__ = [
    "WIDE",
    "WIDTH",
    "axes_at",
    "flush_subnormals",
    "pack",
    "power_of_two",
    "record",
    "recorded",
    "restore_mode",
    "round_down",
    "round_nearest",
    "select",
    "square_root",
    "unpack",
]
