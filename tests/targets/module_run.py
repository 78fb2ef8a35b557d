"""Calling the WebAssembly module under node, its memory laid out from here."""

from __future__ import annotations

import functools
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import model_hash
from motionlab.targets.wasm import build
from motionlab.targets.wasm_compile import SECTION
from motionlab.targets.wasm_module import custom_section
from tests.paths import ROOT

Array = NDArray[Any]

BUILT = ROOT / "frontend" / "kernel.wasm"
"""Where `make` puts the module."""

_PAGE = 65536
_ALIGN = 16


@functools.cache
def module() -> bytes:
    """Return the module of the sources as they are, that of `make` where it is current."""
    if BUILT.is_file() and description(BUILT.read_bytes())["model"] == model_hash():
        return BUILT.read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "kernel.wasm"
        build(file)
        return file.read_bytes()


def description(code: bytes) -> dict[str, Any]:
    """Return what a module says of itself."""
    content = custom_section(code, SECTION)
    assert content is not None
    return json.loads(content)


class Memory:
    """The memory of an instance, and the calls to make on it."""

    def __init__(self) -> None:
        self._top = _ALIGN
        self._arrays: list[tuple[int, Array]] = []
        self._results: list[tuple[int, Array]] = []
        self._calls: list[tuple[Any, ...]] = []

    def put(self, array: Array) -> int:
        """Place an array; return its address."""
        at = self._room(array.nbytes)
        self._arrays.append((at, np.ascontiguousarray(array)))
        return at

    def result(self, array: Array) -> int:
        """Place an array that `run` overwrites by what is there after the calls."""
        at = self.put(array)
        self._results.append((at, array))
        return at

    def call(self, name: str, *parameters: int) -> None:
        """Call a function of the module when `run` runs."""
        self._calls.append((name, *parameters))

    def run(self) -> list[float]:
        """Make the calls in a new instance; return the processor time of each, s."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "kernel.wasm"
            file.write_bytes(module())
            job = {
                "module": str(file),
                "pages": -(-self._top // _PAGE),
                "arrays": [_written(Path(folder), i, *each) for i, each in enumerate(self._arrays)],
                "calls": self._calls,
                "results": [
                    {"file": f"{folder}/result{i}", "at": at, "size": array.nbytes}
                    for i, (at, array) in enumerate(self._results)
                ],
            }
            (Path(folder) / "job.json").write_text(json.dumps(job))
            script = Path(__file__).with_name("run_module.mjs")
            node = (ROOT / "frontend" / "npm", "exec", "--", "node")
            command = (*node, script, f"{folder}/job.json")
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
            for i, (_, array) in enumerate(self._results):
                array[...] = np.fromfile(f"{folder}/result{i}", array.dtype).reshape(array.shape)
        return json.loads(done.stdout.splitlines()[-1])

    def _room(self, size: int) -> int:
        at = self._top
        self._top += -(-size // _ALIGN) * _ALIGN
        return at


def _written(folder: Path, number: int, at: int, array: Array) -> dict[str, Any]:
    file = folder / f"array{number}"
    array.tofile(file)
    return {"file": str(file), "at": at}
