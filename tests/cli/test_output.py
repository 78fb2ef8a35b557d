"""What commands write and say: files and their sizes, overwriting, notes, figures, tables."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from motionlab.cli import main
from motionlab.cli.output import size
from motionlab.executors import progress
from motionlab.reports import tables

SHORT = ["--set", 'trajectory={kind="dwell",duration=0.1}']
OUT = ["run", "circle", *SHORT, "--out", "run.csv"]


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "data"))
    return tmp_path


def test_a_file_is_named_with_its_size(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(OUT) == 0
    count = (here / "run.csv").stat().st_size
    assert capsys.readouterr().err == f"motionlab: wrote run.csv, {size(count)}\n"
    assert (size(999), size(1000), size(20_840_000)) == ("999 bytes", "1 kB", "20.8 MB")


def test_a_file_is_replaced_when_asked_to(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "run.csv").write_text("mine")
    assert main(OUT) == 2
    assert (here / "run.csv").read_text() == "mine"
    assert "--overwrite" in capsys.readouterr().err
    assert main([*OUT, "--overwrite"]) == 0
    assert (here / "run.csv").read_text() != "mine"


@pytest.mark.parametrize(("answer", "code"), [("y\n", 0), ("no\n", 1), ("\n", 1), ("", 1)])
def test_on_a_terminal_it_asks(
    answer: str, code: int, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "run.csv").write_text("mine")
    monkeypatch.setattr(sys, "stdin", Terminal(answer))
    monkeypatch.setattr(sys, "stderr", said := Terminal())
    assert main(OUT) == code
    assert "motionlab: run.csv is there already. Replace it? [y/N] " in said.getvalue()
    assert ((here / "run.csv").read_text() == "mine") == (code == 1)


@pytest.mark.parametrize("where", [("-q", "run"), ("run", "--quiet")])
def test_quiet_leaves_out_notes(
    where: tuple[str, str], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*where, *OUT[1:], "--keep"]) == 0
    assert capsys.readouterr().err == ""


def test_verbose_says_how_long_and_where(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["-v", "scenarios"]) == 0
    assert capsys.readouterr().err.startswith("motionlab: took ")
    assert main(["show", "circel", "--verbose"]) == 2
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("suffix", "begin"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")]
)
def test_a_figure_of_a_file_and_of_a_scenario(suffix: str, begin: bytes, here: Path) -> None:
    assert main(OUT) == 0
    assert main(["plot", "run.csv", "B.x.thrust", "--out", f"file.{suffix}"]) == 0
    assert main(["plot", "circle", *SHORT, "--to", "0.05", "--out", f"run.{suffix}"]) == 0
    for name in ("file", "run"):
        assert (here / f"{name}.{suffix}").read_bytes().startswith(begin)


def test_a_figure_of_a_kept_run(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "circle", *SHORT, "--keep"]) == 0
    run = capsys.readouterr().err.split("kept as ")[1].split()[0]
    assert main(["plot", run, "x.position_reference", "A.y.velocity", "--out", "run.svg"]) == 0
    text = (here / "run.svg").read_text()
    assert text.count('id="legend') == 2


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completion_knows_commands_and_options(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for word in ("montecarlo", "export-controller", "overwrite"):
        assert word in script


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("run ci", {"circle", "circle-resonant", "circa.toml"}),
        ("run circle --out ot", {"other.csv"}),
        ("compare ot", {"other.csv"}),
        ("trajectory export circle ot", {"other.csv"}),
        ("export-controller circle -o re", {"real"}),
    ],
)
def test_bash_completes_files_and_scenarios(
    words: str, wanted: set[str], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    assert "complete -o bashdefault -o default -F" in script
    for name in ("circa.toml", "other.csv"):
        Path(name).touch()
    Path("real").mkdir()
    given = ["motionlab", *words.split()]
    asked = f"COMP_WORDS=({' '.join(given)}); COMP_CWORD={len(given) - 1}; _shtab_motionlab"
    shell = ["bash", "--norc", "-c", f'{script}\n{asked}\nprintf "%s\\n" "${{COMPREPLY[@]}}"']
    found = subprocess.run(shell, capture_output=True, text=True, check=True).stdout.split()
    assert wanted <= set(found)
    assert all(name.startswith(given[-1]) for name in found)


def test_docs_names_a_page(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["docs", "scenarios"]) == 0
    assert Path(capsys.readouterr().out.strip()).is_file()


def test_without_documentation_the_way_to_it_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for place in ("_PACKAGE", "_CHECKOUT"):
        monkeypatch.setattr(f"motionlab.cli.docs.{place}", tmp_path)
    assert main(["docs"]) == 1
    told = capsys.readouterr().err
    assert "make docs" in told
    assert "/help" not in told


# -- tables and bars ------------------------------------------------------------------------------


def table() -> str:
    return tables.table(("error", "value", "unit"), [("largest", "20.5", "um")], right={1})


def test_a_table_in_a_pipe_is_plain() -> None:
    assert table() == "error    value  unit\nlargest   20.5  um"


@pytest.mark.parametrize(
    ("setting", "marked"), [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)]
)
def test_a_table_on_a_terminal(
    setting: dict[str, str], marked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdout", Terminal())
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    for name, value in setting.items():
        monkeypatch.setenv(name, value)
    assert ("\x1b[" in table()) == marked
    plain = "TERM" in setting
    assert tables.in_letters("2 um, 3 us, sum") == (
        "2 um, 3 us, sum" if plain else "2 µm, 3 µs, sum"
    )


def test_the_last_column_is_wrapped_at_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", Terminal())
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setattr("shutil.get_terminal_size", lambda *_, **__: os.terminal_size((40, 20)))
    lines = tables.table(("a", "b"), [("first", "word " * 20)]).splitlines()
    assert len(lines) > 3
    assert max(map(len, lines)) <= 40


def test_progress_is_a_bar_on_a_terminal_and_lines_elsewhere(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delitem(sys.modules, "ipykernel", raising=False)
    with progress.share_done("cases") as done:
        done(0.25)
    assert capsys.readouterr().err.splitlines() == [
        "motionlab: cases 20 %",
        "motionlab: cases 100 %",
    ]
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    monkeypatch.setenv("TERM", "xterm")
    for work in (lambda: progress.share_done("cases"), lambda: progress.tick_bar(200_000)):
        with work() as done:
            assert done is not None
            done(1)
    assert "cases" in terminal.getvalue()
    assert "run" in terminal.getvalue()
    with progress.progress_shown(False), progress.share_done("quiet") as done:
        done(0.5)
    assert "quiet" not in terminal.getvalue()
