"""Lanes in arrays, in compiled code.

The type of an array does not contain the width of its lanes: a reader takes it from a constant or
by lanes that are as wide.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import type_callable

from motionlab.lanes.compiler.vector import (
    LanesType,
    join_vectors,
    split_vectors,
    vector_of,
    vectors_in,
)
from motionlab.lanes.operations import (
    WIDTH,
    axes_at,
    load_vectors,
    pack,
    record,
    recorded,
    store_vectors,
    unpack,
)

_PAIR = ir.VectorType(ir.DoubleType(), 2)
_ALIGN = 8  # numpy promises no more than the alignment of one double


def _row(  # noqa: PLR0913, PLR0917 - numba's lowering, an array, where in it
    context: Any, builder: Any, array_type: Any, array: Any, row: Any, width: int
) -> list[Any]:
    """Return the addresses of the vectors of ``array.flat[row * width :]``, C-contiguous."""
    data = context.make_array(array_type)(context, builder, array).data
    first = builder.mul(row, _i64(width))
    at = [builder.gep(data, [builder.add(first, _i64(i))]) for i in range(0, width, WIDTH)]
    element = ir.FloatType() if array_type.dtype == types.float32 else ir.DoubleType()
    vector = vector_of(element, width)
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
            double = vector_of(ir.DoubleType(), width)
            vectors = [builder.fpext(vector, double) for vector in vectors]
        values.append(join_vectors(builder, vectors))
    return context.make_tuple(builder, sig.return_type, values)


def _rows_to_tick(  # noqa: PLR0913, PLR0917 - as `_row`
    context: Any, builder: Any, array_type: Any, array: Any, tick: Any, width: int
) -> Any:
    """Return how many rows before ``array[tick]`` there are, some of which others may hold."""
    strides = context.make_array(array_type)(context, builder, array).strides
    row = _i64(width * array_type.dtype.bitwidth // 8)
    return builder.mul(tick, builder.sdiv(builder.extract_value(strides, 0), row, flags=["exact"]))


def _i64(value: int) -> Any:
    return ir.Constant(ir.IntType(64), value)


def _register_reader(function: Any) -> None:
    """Register with numba a function that returns a named tuple of lanes of constant width."""

    @infer_global(function)  # pyright: ignore[reportOptionalCall]
    class _Reader(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            record, _, _, *width = args
            lanes = LanesType(WIDTH)
            if width and isinstance(width[0], LanesType):
                lanes = width[0]
            elif width and not isinstance(width[0], types.IntegerLiteral):
                return None  # numba calls again with the constant
            elif width:
                lanes = LanesType(width[0].literal_value)
            cls = record.instance_class
            return signature(types.NamedUniTuple(lanes, len(cls._fields), cls), *args)


_register_reader(unpack)


@lower_builtin(unpack, types.NamedTupleClass, types.Array, types.Integer)
@lower_builtin(unpack, types.NamedTupleClass, types.Array, types.Integer, types.Any)
def _lower_unpack(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    first = context.cast(builder, args[2], sig.args[2], types.int64)
    return _load_rows(context, builder, sig, args, first)


_register_reader(axes_at)


@lower_builtin(axes_at, types.NamedTupleClass, types.Array, types.Integer)
@lower_builtin(axes_at, types.NamedTupleClass, types.Array, types.Integer, types.Any)
def _lower_axes_at(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    count, width = sig.return_type.count, sig.return_type.dtype.width
    tick = context.cast(builder, args[2], sig.args[2], types.int64)
    first = _rows_to_tick(context, builder, sig.args[1], args[1], tick, 2)
    data = context.make_array(sig.args[1])(context, builder, args[1]).data
    data = builder.gep(data, [builder.mul(first, _i64(2))])
    order_type = vector_of(ir.IntType(32), width)
    order = ir.Constant(order_type, [0, 1] * (order_type.count // 2))
    fields = []
    for i in range(count):
        address = builder.bitcast(builder.gep(data, [_i64(2 * i)]), _PAIR.as_pointer())
        pair = builder.load(address, align=_ALIGN)
        vector = builder.shuffle_vector(pair, ir.Constant(_PAIR, ir.Undefined), order)
        fields.append(join_vectors(builder, [vector] * vectors_in(width)))
    return context.make_tuple(builder, sig.return_type, fields)


@type_callable(pack)
def _type_pack(context: Any) -> Any:
    return lambda values, array: types.none


@type_callable(record)
def _type_record(context: Any) -> Any:
    return lambda values, array, tick: types.none


_register_reader(recorded)


def _store_rows(context: Any, builder: Any, sig: Any, args: Any, first: Any) -> Any:
    lanes, array_type = sig.args[0].dtype, sig.args[1]
    single, narrow = array_type.dtype == types.float32, vector_of(ir.FloatType(), lanes.width)
    for i in range(sig.args[0].count):
        value = builder.extract_value(args[0], i)
        vectors = split_vectors(context, builder, value, lanes, lanes.width)
        row = builder.add(first, _i64(i))
        at = _row(context, builder, array_type, args[1], row, lanes.width)
        for vector, address in zip(vectors, at, strict=True):
            stored = builder.fptrunc(vector, narrow) if single else vector
            builder.store(stored, address, align=_ALIGN // 2)
    return context.get_dummy_value()


@lower_builtin(pack, types.NamedUniTuple, types.Array)
def _lower_pack(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _store_rows(context, builder, sig, args, _i64(0))


@lower_builtin(record, types.NamedUniTuple, types.Array, types.Integer)
def _lower_record(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    tick = context.cast(builder, args[2], sig.args[2], types.int64)
    width = sig.args[0].dtype.width
    first = _rows_to_tick(context, builder, sig.args[1], args[1], tick, width)
    return _store_rows(context, builder, sig, args, first)


@lower_builtin(recorded, types.NamedTupleClass, types.Array, types.Integer)
@lower_builtin(recorded, types.NamedTupleClass, types.Array, types.Integer, types.Any)
def _lower_recorded(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    tick = context.cast(builder, args[2], sig.args[2], types.int64)
    return _load_rows(context, builder, sig, args, builder.mul(tick, _i64(sig.return_type.count)))


# -- rows of single vectors -----------------------------------------------------------------------


_register_reader(load_vectors)


@type_callable(store_vectors)
def _type_store_vectors(context: Any) -> Any:
    return lambda values, array, first: types.none


def _vector_rows(context: Any, builder: Any, sig: Any, args: Any, lanes: Any) -> Any:
    """Return a function from row and vector to an address in args[1], from row args[2] on."""
    array = context.make_array(sig.args[1])(context, builder, args[1])
    rows = builder.extract_value(array.shape, 1)
    first = context.cast(builder, args[2], sig.args[2], types.int64)
    vector = vector_of(ir.DoubleType(), lanes.width)

    def address(row: int, number: int) -> Any:
        place = builder.add(builder.mul(rows, _i64(number)), builder.add(first, _i64(row)))
        at = builder.gep(array.data, [builder.mul(place, _i64(vector.count))])
        return builder.bitcast(at, vector.as_pointer())

    return address, range(vectors_in(lanes.width))


@lower_builtin(load_vectors, types.NamedTupleClass, types.Array, types.Integer, types.Any)
def _lower_load_vectors(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    address, vectors = _vector_rows(context, builder, sig, args, sig.return_type.dtype)
    values = [
        join_vectors(builder, [builder.load(address(row, v), align=_ALIGN) for v in vectors])
        for row in range(sig.return_type.count)
    ]
    return context.make_tuple(builder, sig.return_type, values)


@lower_builtin(store_vectors, types.NamedUniTuple, types.Array, types.Integer)
def _lower_store_vectors(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    lanes = sig.args[0].dtype
    address, vectors = _vector_rows(context, builder, sig, args, lanes)
    for row in range(sig.args[0].count):
        value = builder.extract_value(args[0], row)
        split = split_vectors(context, builder, value, lanes, lanes.width)
        for v in vectors:
            builder.store(split[v], address(row, v), align=_ALIGN)
    return context.get_dummy_value()
