"""The command: what it refuses to begin with, and switches from the terminal."""

from __future__ import annotations

import json
import socket
import subprocess

import pytest

from motionlab.cli.main import main
from motionlab.drive.virtual.process import VirtualDrive


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Return the one line with which the command refuses."""
    assert main(["vdrive", *words]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    return told.err


@pytest.mark.parametrize("option", ["address", "control"])
def test_a_port_that_is_in_use(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        words = {
            "address": ["--address", f"127.0.0.1:{port}"],
            "control": ["--address", "127.0.0.1:0", "--control", str(port)],
        }
        line = refused(capsys, *words[option])
    assert f"{option}: UDP port {port} of 127.0.0.1: Address already in use" in line


def test_a_card_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, "--interface", "nope0")
    assert "interface: " in line
    assert "no such network card" in line or "CAP_NET_RAW" in line
    assert "'nope0'" in line


def test_no_right_to_raw_ethernet(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr("motionlab.drive.virtual.server.socket.socket", refuse)
    assert "needs root or the right CAP_NET_RAW" in refused(capsys, "--interface", "lo")


def test_a_card_that_is_down(cards: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    subprocess.run(["ip", "link", "set", cards[0], "down"], check=True)
    try:
        assert f"ip link set {cards[0]} up" in refused(capsys, "--interface", cards[0])
    finally:
        subprocess.run(["ip", "link", "set", cards[0], "up"], check=True)


def test_there_is_no_port_after_the_last_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert "control: there is no port after 65535" in refused(
        capsys, "--address", "127.0.0.1:65535"
    )


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--address=nowhere", "address: is no IP address with or without port; got 'nowhere'"),
        ("--address=127.0.0.1:x", "address: must be a whole number; got 'x'; allowed 0 to 65535"),
        ("--control=70000", "control: must be a whole number; got '70000'; allowed 0 to 65535"),
        ("--start=0.1", "start: must be a pair of positions such as 0.01,0; got '0.1'"),
        ("--start=2,0", "start: must be a pair of positions such as 0.01,0; got '2,0'"),
        ("--seed=-1", "seed: must be a whole number; got '-1'"),
        ("--drift=fast", "drift: must be a number; got 'fast'; allowed -1000 to 1000 ppm"),
        ("--priority=100", "priority: must be a whole number; got '100'; allowed 0 to 99"),
        ("--slow=0", "slow: must be a whole number; got '0'; allowed 1 to 20"),
    ],
)
def test_a_wrong_value_is_told_in_one_line(
    words: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert told in refused(capsys, words)


def test_switches_from_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with VirtualDrive() as drive:
        at = ["--address", f"127.0.0.1:{drive.port}"]
        words = ["--switch", "drop=0.05", "--switch", "fault={node=2, code=0x2310}"]
        assert main(["vdrive", *at, *words]) == 0
        assert capsys.readouterr().out.startswith("switched on: drop=0.05\nframes ")
        assert main(["vdrive", *at, "--switch", "clear=true", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["switches"] == {}
        line = refused(capsys, *at, "--switch", "drop=2")
        assert "drop: is out of range; got 2; allowed >= 0 and <= 1" in line
    assert main(["vdrive", *at, "--switch", "clear=true"]) == 1
    assert "no virtual drive answers" in capsys.readouterr().err
