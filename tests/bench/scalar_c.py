"""Compiling and calling the scalar C reference."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.simulation.kernel import INPUT_ROWS, PARAMETER_ROWS, STATE_ROWS, SUBSTEPS

Array = NDArray[np.float64]

_SOURCE = Path(__file__).with_name("reference.c")
_LARGE = 1e300  # -ffast-math leaves infinity undefined


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
        gcc = shutil.which("gcc")
        if gcc is None:
            raise FileNotFoundError("gcc")
        self.flags = ("-O3", f"-march={arch}", "-ffast-math")
        self.version = _output(gcc, "-dumpfullversion")
        sizes = (f"-DT_S={CONTROL_PERIOD!r}", f"-DSUBSTEPS={SUBSTEPS}")
        with tempfile.TemporaryDirectory() as folder:
            made, library = Path(folder, "reference.o"), Path(folder, "reference.so")
            _output(gcc, *self.flags, *sizes, "-fPIC", "-c", str(_SOURCE), "-o", str(made))
            # Linked without -ffast-math: with it, loading the library would have the whole process
            # flush subnormals, the kernel too.
            _output(gcc, "-shared", str(made), "-o", str(library), "-lm")
            self._library = ctypes.CDLL(str(library))
        rows = [
            getattr(self._library, f"{kind}_rows")() for kind in ("parameter", "state", "input")
        ]
        if rows != [PARAMETER_ROWS, STATE_ROWS, INPUT_ROWS]:
            raise RuntimeError(f"reference.c has {rows} rows, not the kernel's")

    def run(self, parameters: Array, state: Array, inputs: Array) -> Array:
        """Advance lanes as the kernel would, but keep no samples.

        Parameters
        ----------
        parameters : ndarray, shape (lanes, PARAMETER_ROWS)
            One lane after another.
        state : ndarray, shape (lanes, STATE_ROWS)
            Overwritten by the state at the end.
        inputs : ndarray, shape (ticks, INPUT_ROWS, 2)
            As for the kernel.

        Returns
        -------
        ndarray, shape (lanes,)
            Largest following error of each lane, m.
        """
        lanes = len(parameters)
        parameters = np.ascontiguousarray(np.clip(parameters, -_LARGE, _LARGE))
        largest = np.zeros(lanes)
        assert state.flags.c_contiguous and inputs.flags.c_contiguous
        self._library.run_lanes(
            _pointer(parameters),
            _pointer(state),
            _pointer(inputs),
            ctypes.c_long(len(inputs)),
            ctypes.c_int(lanes),
            _pointer(largest),
        )
        return largest


def _pointer(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _output(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout.strip()
