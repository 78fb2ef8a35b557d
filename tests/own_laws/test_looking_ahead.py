"""A law that looks ahead has the same of the motion to come wherever it is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.export.compilers import call, compiler
from tests.own_laws import looking_ahead
from tests.own_laws.looking_ahead import LAW, TEXT
from tests.own_laws.test_everywhere import command, document
from tests.own_laws.with_laws import in_process

SET = "--set=" + "".join(f"{path}={law}" for path, law in LAW.items())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("laws")
    (folder / "preview.py").write_text(TEXT)
    return folder


@pytest.mark.parametrize(
    "check",
    [
        looking_ahead.a_run_has_what_comes,
        looking_ahead.pieces_give_the_same_bits,
        looking_ahead.batches_give_the_same_metrics,
        looking_ahead.a_live_session_has_what_is_known,
        looking_ahead.an_environment_has_it_too,
        looking_ahead.a_unit_takes_it,
        looking_ahead.drives_have_it,
    ],
    ids=lambda check: check.__name__,
)
def test_ahead(check: Callable[[], None], folder: Path) -> None:
    in_process(check, folder)


def test_without_compiled_code_it_is_the_same(folder: Path) -> None:
    in_process(looking_ahead.interpreted, folder, NUMBA_DISABLE_JIT="1")


def test_exported_code_takes_it_and_gives_the_vectors(folder: Path, tmp_path: Path) -> None:
    words = ("export-controller", "circle", "-o", tmp_path / "c", "--variant", "B")
    options = ("--laws", folder, SET, "--seconds", "0.5", "--set=trajectory.lead_in=0.1")
    done = command(*words, *options)
    assert done.returncode == 0, done.stderr
    header = (tmp_path / "c" / "psrm_controller.h").read_text()
    assert "double acceleration_2;" in header and "double phase;" in header
    checked = call("make", "-C", tmp_path / "c", "check", f"CC={compiler('gcc')}")
    assert "1000 periods, 0 numbers beyond" in checked.stdout, checked.stdout + checked.stderr


def test_it_has_margins_of_the_loop_without_it(folder: Path) -> None:
    """A force of the reference alone is no part of the loop."""
    margins = [
        document("loop", "circle", "--laws", folder, *options)["variants"]["B"]["axes"]["x"]
        for options in ((SET,), (SET.replace("=preview", "=off"),))
    ]
    assert margins[0]["phase_margin"] == pytest.approx(margins[1]["phase_margin"], rel=1e-6)
