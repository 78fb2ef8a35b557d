"""Calls of machine code at addresses that a table holds, on rows of eight lanes.

So a law or an effect is compiled once, alone, and the kernel not at all when one is added.
"""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload
from numpy.typing import NDArray

from motionlab.lanes import WIDTH, select
from motionlab.lanes.compiler import entry

Array = NDArray[np.float64]
OnRows = Callable[[Array], None]

_numba: Any = numba  # whose types do not name all that it exports
_carray = _numba.carray


def chosen(mask: Any, values: Any, others: Any) -> Any:
    """Return a record with `values` where `mask` holds and `others` elsewhere."""
    pairs = zip(values, others, strict=True)
    return type(others)(*(select(mask, value, other) for value, other in pairs))


@overload(chosen, strict=False)
def _overload_chosen(mask: Any, values: Any, others: Any) -> Any:
    terms = ", ".join(f"select(mask, values[{k}], others[{k}])" for k in range(len(others)))
    scope = {"select": select, "record": others.instance_class}
    exec(f"def chosen(mask, values, others):\n    return record({terms})", scope)
    return scope["chosen"]


class RowCode:
    """Machine code of functions on rows of eight lanes, by number; compiled at its first use.

    Parameters
    ----------
    count : int
        Functions.
    rows : int
        Rows that each takes.
    """

    def __init__(self, count: int, rows: int) -> None:
        self.addresses = np.zeros(count, dtype=np.int64)
        self.rows = rows
        self.code: dict[int, Any] = {}
        self.lock = threading.Lock()
        self._kept: list[Any] = []  # code of former versions, which a loop may be in

    def require(self, number: int, made: Callable[[], tuple[OnRows, str | None]]) -> None:
        """Compile a function, or load it, where that has not been done."""
        with self.lock:
            if number not in self.code:
                self.put(number, self.compiled(*made()))

    def compiled(self, call: OnRows, source: str | None) -> Any:
        """Return the machine code of a function, without a number yet.

        Parameters
        ----------
        call : callable
            Takes rows, shape (rows, WIDTH).
        source : str or None
            Text of the file of one's own that it is from: the model's hash does not know it.
        """
        if _numba.config.DISABLE_JIT:
            return call
        rows = self.rows

        def at(pointer: Any) -> None:
            call(_carray(pointer, (rows, WIDTH)))

        if source:  # compiled code is kept under this name
            at.__qualname__ += f"-{hashlib.sha256(source.encode()).hexdigest()[:16]}"
        return entry(types.void(types.CPointer(types.float64)))(at)

    def put(self, number: int, code: Any) -> None:
        """Have code run under a number, in place of a former one; None: what `require` compiles.

        A number beyond those that there are is added; lanes that are being called keep their table.
        """
        if (missing := number + 1 - len(self.addresses)) > 0:
            self.addresses = np.concatenate([self.addresses, np.zeros(missing, dtype=np.int64)])
        self._kept.append(self.code.pop(number, None))
        if code is not None:
            self.code[number] = code
            self.addresses[number] = getattr(code, "address", 0)  # none where nothing is compiled


def caller(rows: int) -> Any:
    """Return the function that compiled code calls with an address, rows and a vector.

    It runs the code at the address on ``rows[vector]``, shape (vectors, `rows`, WIDTH).
    """
    size = ir.Constant(ir.IntType(64), rows * WIDTH)

    @intrinsic
    def call(_: Any, address: Any, rows: Any, vector: Any) -> Any:
        def lower(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            array = context.make_array(signature.args[1])(context, builder, values[1])
            place = context.cast(builder, values[2], signature.args[2], types.int64)
            pointer = array.data.type
            function = ir.FunctionType(ir.VoidType(), [pointer]).as_pointer()
            first = builder.gep(array.data, [builder.mul(place, size)])
            builder.call(builder.inttoptr(values[0], function), [first])
            return context.get_dummy_value()

        return types.void(address, rows, vector), lower

    return call
