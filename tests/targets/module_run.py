"""Calling the WebAssembly module under node, its memory laid out from here."""

from __future__ import annotations

import functools
import json
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import module_hash
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
    if BUILT.is_file() and description(BUILT.read_bytes())["module"] == module_hash():
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
        """Place an array that is overwritten by what is there after the calls."""
        at = self.put(array)
        self._results.append((at, array))
        return at

    def call(self, name: str, *parameters: int) -> None:
        """Call a function of the module when `run` runs."""
        self._calls.append((name, *parameters))

    def run(self) -> list[float]:
        """Make the calls in a new instance under node; return the processor time of each, s."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            self.write_job(folder)
            script = Path(__file__).with_name("run_module.mjs")
            command = (ROOT / "frontend" / "npm", "exec", "--", "node", script, folder)
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
            self.take([(folder / f"result{i}").read_bytes() for i in range(len(self._results))])
        return json.loads(done.stdout.splitlines()[-1])

    def write_job(self, folder: Path) -> None:
        """Write the module, the calls and the arrays as files for module_job.mjs."""
        (folder / "kernel.wasm").write_bytes(module())
        for number, (_, array) in enumerate(self._arrays):
            array.tofile(folder / f"array{number}")
        job = {
            "module": "kernel.wasm",
            "pages": -(-self._top // _PAGE),
            "arrays": [
                {"file": f"array{number}", "at": at} for number, (at, _) in enumerate(self._arrays)
            ],
            "calls": self._calls,
            "results": [
                {"file": f"result{number}", "at": at, "size": array.nbytes}
                for number, (at, array) in enumerate(self._results)
            ],
        }
        (folder / "job.json").write_text(json.dumps(job))

    def take(self, results: Sequence[bytes]) -> None:
        """Overwrite the arrays of `result` by what the calls left."""
        for (_, array), content in zip(self._results, results, strict=True):
            array[...] = np.frombuffer(content, array.dtype).reshape(array.shape)

    def _room(self, size: int) -> int:
        at = self._top
        self._top += -(-size // _ALIGN) * _ALIGN
        return at
