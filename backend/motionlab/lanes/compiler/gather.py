"""Reading tables in compiled code: each lane from a place of its own."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_builtin
from numba.extending import type_callable

from motionlab.lanes.compiler.vector import (
    LanesType,
    join_vectors,
    split_vectors,
    vector_of,
)
from motionlab.lanes.operations import WIDTH, load_four

_FOUR = ir.VectorType(ir.DoubleType(), 4)
_WHOLE = 2.0**52  # added to a whole number, it leaves that number in the bits of the mantissa
_MANTISSA = 2**52 - 1
_ALIGN = 8


@type_callable(load_four)
def _type_load_four(context: Any) -> Any:
    def typer(table: Any, index: Any) -> Any:
        if isinstance(table, types.Array) and isinstance(index, LanesType):
            return types.UniTuple(index, 4)
        return None

    return typer


@lower_builtin(load_four, types.Array, types.Any)
def _lower_load_four(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    data = context.make_array(sig.args[0])(context, builder, args[0]).data
    width = sig.args[1].width
    vectors = split_vectors(context, builder, args[1], sig.args[1], width)
    columns_of = [_columns(builder, data, vector) for vector in vectors]
    columns = [join_vectors(builder, list(parts)) for parts in zip(*columns_of, strict=True)]
    return context.make_tuple(builder, sig.return_type, columns)


def _columns(builder: Any, data: Any, index: Any) -> list[Any]:
    """Return the four numbers of each lane of one vector."""
    width = index.type.count
    whole = vector_of(ir.IntType(64), width)
    shifted = builder.fadd(index, ir.Constant(index.type, [_WHOLE] * width))
    bits = builder.and_(builder.bitcast(shifted, whole), ir.Constant(whole, [_MANTISSA] * width))
    rows = []
    for lane in range(width):
        place = builder.extract_element(bits, ir.Constant(ir.IntType(32), lane))
        address = builder.bitcast(builder.gep(data, [place]), _FOUR.as_pointer())
        rows.append(builder.load(address, align=_ALIGN))
    return _transposed(builder, rows)


def _transposed(builder: Any, rows: list[Any]) -> list[Any]:
    """Return the columns of two or eight rows of four."""

    def shuffled(a: Any, b: Any, *order: int) -> Any:
        kind = ir.VectorType(ir.IntType(32), len(order))
        return builder.shuffle_vector(a, b, ir.Constant(kind, list(order)))

    if len(rows) < WIDTH:
        return [shuffled(*rows, k, k + 4) for k in range(4)]
    # Eight loads of four and a transposition: a vector gather takes several times as long.
    wide = [shuffled(rows[k], rows[k + 4], *range(8)) for k in range(4)]  # lane k and lane k + 4
    pairs = [
        (
            shuffled(a, b, 0, 8, 2, 10, 4, 12, 6, 14),
            shuffled(a, b, 1, 9, 3, 11, 5, 13, 7, 15),
        )
        for a, b in (wide[:2], wide[2:])
    ]
    low, high = (0, 1, 8, 9, 4, 5, 12, 13), (2, 3, 10, 11, 6, 7, 14, 15)
    (even, odd), (even_2, odd_2) = pairs
    return [
        shuffled(even, even_2, *low),
        shuffled(odd, odd_2, *low),
        shuffled(even, even_2, *high),
        shuffled(odd, odd_2, *high),
    ]
