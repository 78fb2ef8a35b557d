"""What commands print on a terminal of 80 or 120 columns: nothing lost, no word or number cut."""

from __future__ import annotations

import fcntl
import os
import re
import struct
import sys
import termios
import threading
import unicodedata
from collections import Counter
from collections.abc import Iterator

import pytest

from motionlab.cli import main

COMMANDS = (
    "loop circle",
    "fields friction",
    "fields plant.x",
    "laws",
    "scenarios",
    "check circle",
    "sharing",
    "platform",
    "design",
    "run fig5",
    "serve --show-settings",
    "fields trajectory --scenario pentagram",
    "why circle",
)


def on_pipe(capsys: pytest.CaptureFixture[str], command: str) -> str:
    main(command.split())
    return capsys.readouterr().out


def on_terminal(monkeypatch: pytest.MonkeyPatch, command: str, columns: int) -> str:
    """Return what a command prints where stdout is a terminal of so many columns."""
    ours, theirs = os.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("COLUMNS", raising=False)
    pieces: list[bytes] = []

    def read() -> None:
        try:
            while piece := os.read(ours, 65536):
                pieces.append(piece)
        except OSError:  # the other side has closed
            pass

    reader = threading.Thread(target=read)
    reader.start()
    with open(theirs, "w", encoding="utf-8") as terminal, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", terminal)
        # What asks for the size of a terminal looks at the first stdout.
        patch.setattr(sys, "__stdout__", terminal)
        main(command.split())
    reader.join()
    os.close(ours)
    text = b"".join(pieces).decode().replace("\r\n", "\n")
    return re.sub(r"\x1b\[\d*m", "", text)


def cells(text: str) -> int:
    """Return the columns that text takes on a terminal."""
    wide = [unicodedata.east_asian_width(letter) in "WF" for letter in text]
    return sum(
        0 if unicodedata.combining(letter) else 1 + two
        for letter, two in zip(text, wide, strict=True)
    )


def words(text: str) -> Counter[str]:
    return Counter(text.replace("µ", "u").split())


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_terminal_loses_nothing(
    command: str,
    columns: int,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    piped = on_pipe(capsys, command)
    shown = on_terminal(monkeypatch, command, columns)
    assert piped
    # Where a row is a block, the head of its first cell is left out: the cell stands above.
    lost = words(piped) - words(shown) - words("field law, parameter setting")
    assert not lost, "words or numbers that the terminal does not show whole"
    assert_fits(shown, columns)


def assert_fits(shown: str, columns: int) -> None:
    for line in shown.splitlines():
        assert cells(line) <= columns or len(line.split()) == 1, line


NAMES = {
    "wide": " ".join(3 * ["円の走行 圆形轨迹 é"]),
    "long": "a name of many words that goes on for longer than the whole of a terminal has",
    "one": 100 * "x",
}


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(tmp_path_factory.mktemp("data")))
        for name in NAMES.values():
            assert main(["run", "circle", "-q", "--keep", "--name", name]) == 0
        yield


@pytest.mark.usefixtures("kept")
@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize(
    "command",
    [
        "runs",
        "runs nothing",
        f"glitches {NAMES['one']}",
        f"spectrum {NAMES['one']} --column B.x.following_error",
        f"compare {NAMES['one']} {NAMES['one']}",
    ],
)
def test_a_terminal_loses_nothing_of_kept_runs(
    command: str,
    columns: int,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    piped = on_pipe(capsys, command)
    shown = on_terminal(monkeypatch, command, columns)
    assert piped
    assert not words(piped) - words(shown) - words("run channel")
    assert_fits(shown, columns)


@pytest.mark.usefixtures("kept")
def test_columns_stand_below_each_other_beside_wide_letters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shown = on_terminal(monkeypatch, "runs", 240).splitlines()
    errors = [line for line in shown if "A.x" in line]
    assert len(errors) == len(NAMES)
    assert len({cells(line[: line.index("A.x")]) for line in errors}) == 1


def test_a_row_that_fits_nowhere_becomes_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = on_terminal(monkeypatch, "fields variants.A.controller.model.x.friction.F_c", 60)
    assert [line.split(maxsplit=1) for line in shown.splitlines()] == [
        ["variants.A.controller.model.x.friction.F_c"],
        ["value", "0.2399"],
        ["unit", "N"],
        ["allowed", ">= 1e-06 and <= 100"],
        ["meaning", "Coulomb friction"],
    ]
