"""What is wrong with the file of a drive link is told at once, and nothing is begun."""

from __future__ import annotations

from pathlib import Path

import pytest

from motionlab.cli.main import main
from motionlab.errors import BAD_INPUT
from tests.paths import ROOT

SHIPPED = (ROOT / "configs" / "drives" / "virtual.toml").read_text()
LAST_NODE = next(line for line in SHIPPED.splitlines(True) if 'axis = "y", phase = "c"' in line)
WRONG = {
    "beyond its range": (
        ("current_max = 10.0", "current_max = 1000.0"),
        "x.current_max: is out of range; got 1000.0; allowed > 0 and <= 100 A",
    ),
    "negative": (
        ("velocity_max = 0.5", "velocity_max = -0.5"),
        "x.velocity_max: is out of range; got -0.5; allowed > 0 and <= 5 m/s",
    ),
    "no range": (
        ("position_min = -0.0845", "position_min = 0.09"),
        "x: position_min = 0.09 m is not below position_max = 0.0845 m",
    ),
    "beyond the rating": (
        ("current_max = 10.0", "current_max = 30.0"),
        "drive: x.current_max = 30 A is more than twice the rated current of drive x a, 10 A",
    ),
    "later than the watchdog": (
        ("[link]", "[link]\nloss = 0.03"),
        "link: loss = 0.03 s must be below watchdog = 0.02 s",
    ),
    "five drives": ((LAST_NODE, ""), "nodes: has too few items; got 5; allowed 6"),
    "a drive twice": (
        ('axis = "y", phase = "c"', 'axis = "y", phase = "b"'),
        "drive: more than one drive for y b, none for y c",
    ),
    "no such drive": (
        ("encoder = 4 ", "encoder = 40 "),
        "y.encoder: is out of range; got 40; allowed >= 1 and <= 6",
    ),
    "one encoder for both axes": (
        ("encoder = 4 ", "encoder = 1 "),
        "drive: y.encoder = 1 is drive x a: the encoder of an axis is read by one of its own",
    ),
    "more counts than a drive has": (
        ("resolution = 50e-9", "resolution = 1e-12"),
        "x: resolution = 1e-12 m: 0.0845 m from count 0 to a limit of position are beyond",
    ),
    "a number of many digits": (("port = 34980", f"port = {'9' * 5000}"), "is no TOML: Exceeds"),
    "text": (
        ("velocity_max = 0.5", 'velocity_max = "fast"'),
        "x.velocity_max: must be a number; got 'fast'; allowed > 0 and <= 5 m/s",
    ),
    "unknown key": (("[link]", "[link]\nspeed = 3"), "link.speed: unknown key; got 3; allowed"),
    "no network card": (
        ('carrier = "udp"', 'carrier = "ethernet"'),
        "link: carrier ethernet needs the name of a network card in interface",
    ),
    "no TOML": (("[link]", "[[["), "is no TOML: "),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_file_is_refused(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (before, after), expected = WRONG[name]
    assert before in SHIPPED
    file = tmp_path / "drive.toml"
    file.write_text(SHIPPED.replace(before, after, 1))
    assert main(["serve", "--port", "0", "--drive", str(file)]) == BAD_INPUT
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("motionlab: ")
    assert expected in line


def test_a_file_that_cannot_be_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for file, reason in (
        (tmp_path / "none.toml", "No such file"),
        (tmp_path, "Is a directory"),
        ("a" * 5000, "File name too long"),
    ):
        assert main(["serve", "--port", "0", "--drive", str(file)]) == BAD_INPUT
        assert f"motionlab: drive: {file}: {reason}" in capsys.readouterr().err
