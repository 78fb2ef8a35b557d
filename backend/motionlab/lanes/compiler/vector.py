"""Operations on lanes in compiled code: one LLVM vector ``<8 x double>``, or two side by side."""

from __future__ import annotations

import functools
import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import models, register_model, type_callable

from motionlab.lanes.operations import (
    WIDTH,
    anywhere,
    power_of_two,
    round_down,
    round_nearest,
    select,
    square_root,
)

_FLAGS = ("contract", "arcp", "nsz")


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


def vector_of(element: Any, width: int) -> Any:
    """Return LLVM's type of one vector of `width` lanes, of which it holds WIDTH at most."""
    return ir.VectorType(element, min(width, WIDTH))


def vectors_in(width: int) -> int:
    """Return how many vectors `width` lanes are."""
    return max(width // WIDTH, 1)


def _side_by_side(element: Any, width: int) -> Any:
    """Return LLVM's type of `width` lanes: one vector, or an array of them."""
    vector, count = vector_of(element, width), vectors_in(width)
    return vector if count == 1 else ir.ArrayType(vector, count)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _side_by_side(ir.DoubleType(), fe_type.width))


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _side_by_side(ir.IntType(1), fe_type.width))


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
    count = vectors_in(width)
    if _is_number(ty):
        scalar = context.cast(builder, value, ty, types.float64)
        return [_repeat(builder, scalar, vector_of(ir.DoubleType(), width))] * count
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
    """Return the results of `emit` for the arguments, vector by vector."""
    width = sig.return_type.width
    pairs = zip(args, sig.args, strict=True)
    split = [split_vectors(context, builder, value, ty, width) for value, ty in pairs]
    return join_vectors(builder, [emit(builder, *some) for some in zip(*split, strict=True)])


def _repeat(builder: Any, scalar: Any, vector_type: Any) -> Any:
    one = builder.insert_element(ir.Constant(vector_type, ir.Undefined), scalar, i32(0))
    order = ir.Constant(ir.VectorType(ir.IntType(32), vector_type.count), [0] * vector_type.count)
    return builder.shuffle_vector(one, ir.Constant(vector_type, ir.Undefined), order)


def i32(value: int) -> Any:
    """Return a whole number as LLVM's constant."""
    return ir.Constant(ir.IntType(32), value)


# -- operators ------------------------------------------------------------------------------------


def _register_operator(op: Any, emit: Any, *, result: Any, arity: int = 2) -> None:
    """Register `op` with numba as lane-wise, with scalars repeated."""

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
        vector = args[0].type
        kind = ir.FunctionType(vector, [vector] * len(args))
        full_name = f"{name}.v{vector.count}f64"
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


@type_callable(anywhere)
def _type_anywhere(context: Any) -> Any:
    return lambda mask: types.boolean if isinstance(mask, MaskType) else None


@lower_builtin(anywhere, MaskType)
def _lower_anywhere(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    (mask,), width = args, sig.args[0].width
    count = vectors_in(width)
    vectors = [mask] if count == 1 else [builder.extract_value(mask, i) for i in range(count)]
    bits = ir.IntType(vectors[0].type.count)
    whole = functools.reduce(builder.or_, (builder.bitcast(each, bits) for each in vectors))
    return builder.icmp_unsigned("!=", whole, ir.Constant(bits, 0))


def _register_unary(function: Any, emit: Any) -> None:
    @type_callable(function)
    def _type(context: Any) -> Any:
        return lambda x: x if _is_lanes(x) else None

    lower_builtin(function, LanesType)(functools.partial(_emit_each, emit))


def _emit_power_of_two(builder: Any, n: Any) -> Any:
    # Adding 1.5 * 2**52 leaves n + bias in the low bits of the mantissa; shifted by 52 they are
    # the exponent. AVX2 has no conversion from double to 64-bit integer, this needs none.
    width = n.type.count
    kind = vector_of(ir.IntType(64), width)
    shifted = builder.fadd(n, ir.Constant(n.type, [1.5 * 2.0**52 + 1023.0] * width))
    bits = builder.shl(builder.bitcast(shifted, kind), ir.Constant(kind, [52] * width))
    return builder.bitcast(bits, n.type)


_register_unary(square_root, _intrinsic("llvm.sqrt"))
_register_unary(round_down, _intrinsic("llvm.floor"))
_register_unary(round_nearest, _intrinsic("llvm.rint"))
_register_unary(power_of_two, _emit_power_of_two)
