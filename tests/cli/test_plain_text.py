"""What comes from outside reaches no terminal as control characters."""

from __future__ import annotations

import argparse
import itertools
import json
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motionlab.cli import main
from motionlab.cli.main import _parser  # pyright: ignore[reportPrivateUsage]
from motionlab.reports.plain_text import without_controls
from motionlab.server.serve import _PlainLines  # pyright: ignore[reportPrivateUsage]

TITLE = "\x1b]0;OWNED\x07\x1b[2J"
HOSTILE = f"a{TITLE}\x7f\x9b31m\x85\r\u202eb\u2066\u200f\u2028"


def is_plain(text: str) -> bool:
    return not any(
        (ord(letter) < 0x20 and letter not in "\n\t")
        or 0x7F <= ord(letter) < 0xA0
        or letter
        in "\u200e\u200f\u2028\u2029\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
        for letter in text
    )


def test_control_characters_are_escapes() -> None:
    assert without_controls("a\x1b[2J\x7f\x9b\u202eb") == r"a\x1b[2J\x7f\x9b\u202eb"
    assert without_controls("Größe\t1 µm\r\n") == "Größe\t1 µm\r\n"
    assert without_controls("done\rFAIL") == r"done\x0dFAIL"
    assert is_plain(without_controls(HOSTILE))


def test_headers_of_a_file_are_plain(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "m.csv"
    rows = "\n".join(f"{k / 1000},{k}" for k in range(20))
    file.write_text(f"t [s],a{TITLE}\x7f\x9b\u202e\n{rows}\n", encoding="utf-8")
    main(["import", str(file), "--preview"])
    written = capsys.readouterr()
    assert "OWNED" in written.out
    assert is_plain(written.out + written.err)


def test_labels_of_a_scenario_are_plain(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "s.toml"
    assert main(["show", "circle"]) == 0
    text = capsys.readouterr().out
    lines = [line for line in text.splitlines() if line.startswith(("name = ", "label = "))]
    assert lines
    for line in lines:
        text = text.replace(line, f"{line[:-1]}{json.dumps(TITLE)[1:]}")
    file.write_text(text)
    for command in ("check", "run"):
        main([command, str(file)])
        written = capsys.readouterr()
        assert is_plain(written.out + written.err)


def test_a_log_line_is_one_line() -> None:
    record = logging.LogRecord("m", logging.INFO, "f", 1, f"by %s\nforged {HOSTILE}", ("x",), None)
    line = _PlainLines("%(levelname)s %(message)s").format(record)
    assert line.startswith("INFO by x\\nforged")
    assert "\n" not in line
    assert is_plain(line)


def parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    yield parser
    for action in parser._actions:  # pyright: ignore[reportPrivateUsage]
        if isinstance(action, argparse._SubParsersAction):  # pyright: ignore[reportPrivateUsage]
            for inner in action.choices.values():
                yield from parsers(inner)


def options() -> list[Any]:
    """Return every option of every command that takes a value."""
    return [
        pytest.param(parser, action.option_strings[-1], id=f"{parser.prog} {action.dest}")
        for parser in parsers(_parser(["--help"]))
        for action in parser._actions  # pyright: ignore[reportPrivateUsage]
        if action.option_strings and action.nargs is None
    ]


def test_a_value_may_begin_with_a_minus(capsys: pytest.CaptureFixture[str]) -> None:
    values = ("-0.001,0.002", "-.5", "-1e-3,2", "-5:5")
    assert len(options()) > 100
    for (parser, option), value in itertools.product((p.values for p in options()), values):
        try:
            parser.parse_known_args([option, value])
        except (Exception, SystemExit):
            pass  # it may need other arguments, or refuse the value
        assert "expected one argument" not in capsys.readouterr().err, (parser.prog, option)
