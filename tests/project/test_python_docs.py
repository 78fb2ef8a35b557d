"""What docs/ says about Python is run: the scripts of its page, and both notebooks."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from tests.paths import ROOT
from tests.project.printed_output import same_text
from tests.server.servers import PATIENCE, Server

SCRIPT = re.compile(r"^```python\n(.*?)^```\n(?:\nprints\n\n((?:    [^\n]*\n)+))?", re.M | re.S)
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))

LONG_WORK = "import motionlab\nmotionlab.montecarlo(cases=20).document.cases and None"


def test_the_scripts_of_the_page_print_what_it_says(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scripts = SCRIPT.findall((ROOT / "docs" / "python.md").read_text())
    assert len(scripts) >= 4
    names: dict[str, Any] = {}
    for script, expected in scripts:
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(script.replace("127.0.0.1:8000", f"127.0.0.1:{server.port}"), names)
        if expected:
            assert same_text(printed.getvalue(), re.sub("^    ", "", expected, flags=re.M))


def test_the_notebooks_run_and_print_what_they_hold(tmp_path: Path) -> None:
    """One after another in one kernel, which forgets all names of the one before."""
    assert len(NOTEBOOKS) > 1
    whole = nbformat.v4.new_notebook()
    whole.cells.append(nbformat.v4.new_code_cell(LONG_WORK))
    for path in NOTEBOOKS:
        cells = nbformat.read(path, as_version=4).cells
        assert any(map(texts, cells)) and any(map(figures_of, cells)), path
        whole.cells += [nbformat.v4.new_code_cell("%reset -f"), *cells]
    expected = [texts(cell) for cell in whole.cells]
    figures = [figures_of(cell) for cell in whole.cells]
    NotebookClient(
        whole,
        kernel_name="python3",
        timeout=int(PATIENCE),
        resources={"metadata": {"path": str(tmp_path)}},
    ).execute()
    for cell, text in zip(whole.cells, expected, strict=True):
        assert same_text(texts(cell), text), cell.source
    assert [figures_of(cell) for cell in whole.cells] == figures
    # Progress is shown while it lasts, and leaves nothing in the file.
    shown = [output for cell in whole.cells for output in cell.get("outputs", [])]
    assert not [output for output in shown if output.get("name") == "stderr"]
    bars = whole.cells[0].outputs
    assert bars and all(output.data == {} for output in bars)


def texts(cell: Any) -> str:
    """Return what a cell printed and its value as text; figures tell only their size."""
    found = [
        output.text if output.output_type == "stream" else output.data.get("text/plain", "")
        for output in cell.get("outputs", [])
        if output.output_type != "stream" or output.name == "stdout"
    ]
    return "".join(found)


def figures_of(cell: Any) -> int:
    """Return how many figures a cell shows."""
    return sum("image/png" in output.get("data", {}) for output in cell.get("outputs", []))
