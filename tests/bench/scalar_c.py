"""Compiling and calling the C references: one lane at a time, and sixteen side by side."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.law_calls import LAWS_BY_NUMBER
from motionlab.kernel.layout import INPUT_ROWS, LAW_NUMBER, PARAMETERS, STATES
from motionlab.timing import CONTROL_PERIOD, SUBSTEPS

Array = NDArray[np.float64]

_LANES = 16
"""Lanes side by side; eight or thirty-two are no faster."""
_LARGE = 1e300  # -ffast-math leaves infinity undefined


# The reference has the parameters and the state of every law in rows of their own.
_LAWS = {
    name: float(number)
    for number, name in enumerate(
        ("off", "lugre-observer", "published-k", "residual-k", "canudas-de-wit", "reversed-k")
    )
}
_APART = "law", "effects", "model_subdivision", "controller.learnt"
_OF_LAWS = ("from_reference", "gain", "alpha", "regularisation", "z_limit", "k_d_share")
_AFTER = PARAMETERS.index("compensation.enabled") + 1
_PARAMETERS = (
    *(name for name in PARAMETERS[:_AFTER] if name not in _APART),
    *_OF_LAWS,
    *(name for name in PARAMETERS[_AFTER:] if not name.startswith(_APART)),
)
_BEFORE = STATES.index("memory.e_last") + 1
_STATES = (
    *STATES[:_BEFORE],
    "z",
    "residual",
    *(name for name in STATES[_BEFORE:] if not name.startswith(_APART)),
)
_KEPT = [row for row, name in enumerate(STATES) if not name.startswith(_APART)]
_KEPT_HERE = [_STATES.index(STATES[row]) for row in _KEPT]


def _rows(parameters: Array) -> Array:
    """Return the rows of the reference from the kernel's, shape (rows, lanes)."""
    rows = np.zeros((len(_PARAMETERS), parameters.shape[1]))
    for row, name in enumerate(_PARAMETERS):
        if name not in _OF_LAWS:
            rows[row] = parameters[PARAMETERS.index(name)]
    first = PARAMETERS.index("law.p_0")
    for lane, number in enumerate(parameters[LAW_NUMBER]):
        law = LAWS_BY_NUMBER[int(number)]
        rows[_PARAMETERS.index("compensation.law"), lane] = _LAWS[law.name]
        for place, name in enumerate(law.Parameters._fields):
            rows[_PARAMETERS.index(name), lane] = parameters[first + place, lane]
    return np.clip(rows, -_LARGE, _LARGE)


def _states(state: Array) -> Array:
    """Return the reference's rows of a state, shape (rows, lanes), in which no law has run yet."""
    rows = np.zeros((len(_STATES), state.shape[1]))
    rows[_KEPT_HERE] = state[_KEPT]
    return rows


class ScalarC:
    """The C reference, compiled.

    Parameters
    ----------
    arch : str
        gcc's ``-march``.

    Raises
    ------
    FileNotFoundError
        If there is no gcc.
    """

    def __init__(self, arch: str = "native") -> None:
        self._library, self.flags, self.version = _compiled("reference.c", arch)

    def run(self, parameters: Array, state: Array, inputs: Array) -> Array:
        """Advance lanes as the kernel would, but keep no samples.

        Parameters
        ----------
        parameters : ndarray, shape (lanes, PARAMETER_ROWS)
            One lane after another.
        state : ndarray, shape (lanes, STATE_ROWS)
            Overwritten by the state at the end, but that of laws.
        inputs : ndarray, shape (ticks, INPUT_ROWS, 2)
            As for the kernel.

        Returns
        -------
        ndarray, shape (lanes,)
            Largest following error of each lane, m.
        """
        lanes = len(parameters)
        rows, now = np.ascontiguousarray(_rows(parameters.T).T), _states(state.T).T.copy()
        largest = np.zeros(lanes)
        assert inputs.flags.c_contiguous
        self._library.run_lanes(
            _pointer(rows),
            _pointer(now),
            _pointer(inputs),
            ctypes.c_long(len(inputs)),
            ctypes.c_int(lanes),
            _pointer(largest),
        )
        state[:, _KEPT] = now[:, _KEPT_HERE]
        return largest


class LanesC:
    """The C reference in lanes, compiled.

    Parameters
    ----------
    arch : str
        gcc's ``-march``.

    Raises
    ------
    FileNotFoundError
        If there is no gcc.
    """

    def __init__(self, arch: str = "native") -> None:
        more = ("-fopenmp-simd", f"-DW={_LANES}")
        self._library, self.flags, self.version = _compiled("reference_lanes.c", arch, *more)

    def run(self, parameters: Array, state: Array, inputs: Array) -> Array:
        """Advance lanes as a batch would, but gather no metrics; see `ScalarC.run`.

        Parameters
        ----------
        parameters : ndarray, shape (PARAMETER_ROWS, lanes)
            The number of lanes is a multiple of sixteen.
        state : ndarray, shape (STATE_ROWS, lanes)
            Overwritten by the state at the end.
        inputs : ndarray, shape (ticks, INPUT_ROWS, 2)
            As for the kernel.
        """
        largest = np.zeros(parameters.shape[1])
        for first in range(0, len(largest), _LANES):
            here = slice(first, first + _LANES)
            par = np.ascontiguousarray(_rows(parameters[:, here]))
            now, peak = np.ascontiguousarray(_states(state[:, here])), np.zeros(_LANES)
            self._library.run_lanes(
                _pointer(par),
                _pointer(now),
                _pointer(inputs),
                ctypes.c_long(len(inputs)),
                _pointer(peak),
            )
            state[_KEPT, here], largest[here] = now[_KEPT_HERE], peak
        return largest


def _compiled(source: str, arch: str, *more: str) -> tuple[ctypes.CDLL, tuple[str, ...], str]:
    """Return a C reference, ready to be called, with its flags and the compiler's version."""
    gcc = shutil.which("gcc")
    if gcc is None:
        raise FileNotFoundError("gcc")
    flags = ("-O3", f"-march={arch}", "-ffast-math")
    sizes = (f"-DT_S={CONTROL_PERIOD!r}", f"-DSUBSTEPS={SUBSTEPS}", *more)
    path = str(Path(__file__).with_name(source))
    with tempfile.TemporaryDirectory() as folder:
        made, library = Path(folder, "reference.o"), Path(folder, "reference.so")
        _output(gcc, *flags, *sizes, "-fPIC", "-c", path, "-o", str(made))
        # Linked without -ffast-math: with it, loading the library would have the whole process
        # flush subnormals, the kernel too.
        _output(gcc, "-shared", str(made), "-o", str(library), "-lm")
        loaded = ctypes.CDLL(str(library))
    rows = [getattr(loaded, f"{kind}_rows")() for kind in ("parameter", "state", "input")]
    if rows != [len(_PARAMETERS), len(_STATES), INPUT_ROWS]:
        raise RuntimeError(f"{source} has {rows} rows, not those that are written here")
    return loaded, flags, _output(gcc, "-dumpfullversion")


def _pointer(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _output(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout.strip()
