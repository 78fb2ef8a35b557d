"""``motionlab scenarios`` and ``motionlab show``."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0
    return capsys.readouterr().out


def test_every_shipped_scenario_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    lines = printed(capsys, "scenarios").splitlines()
    assert [line.split()[0] for line in lines] == names("scenarios")
    listed = json.loads(printed(capsys, "scenarios", "--json"))
    assert [entry["name"] for entry in listed] == names("scenarios")
    for line, entry in zip(lines, listed, strict=True):
        assert entry["title"] == load_scenario(entry["name"]).title
        assert line.endswith(entry["title"])


@pytest.mark.parametrize("name", names("scenarios"))
def test_what_is_shown_is_the_scenario(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(capsys, "show", name)
    file = tmp_path / "shown.toml"
    file.write_text(text, encoding="utf-8")
    assert load_scenario(file) == load_scenario(name)
    shown = json.loads(printed(capsys, "show", name, "--json"))
    assert load_scenario(shown) == load_scenario(name)
    assert tomllib.loads(text) == shown


def test_changes_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "show", "circle", "--set", "plant.x.mass=6.5", "--set", "seed=7")
    shown = tomllib.loads(text)
    assert (shown["plant"]["x"]["mass"], shown["seed"]) == (6.5, 7)


def test_what_is_wrong_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "circel"]) == 2
    assert "did you mean 'circle'" in capsys.readouterr().err
    assert main(["show", "--set", "plant.x.mass=-1"]) == 2
    assert "plant.x.mass: is out of range" in capsys.readouterr().err
