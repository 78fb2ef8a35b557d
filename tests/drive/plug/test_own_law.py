"""A law of one's own on the virtual drive, through the server: it moves, and its state is kept."""

from __future__ import annotations

from pathlib import Path

import httpx
import numpy as np
import pytest

from motionlab.drive.virtual.process import VirtualDrive
from tests.drive.link.rig import SLOW
from tests.drive.plug.test_motion import DRIVE, SHORT, Operator, ended, kept
from tests.e2e.actions import link_file
from tests.own_laws.looking_ahead import LAW, TEXT
from tests.own_laws.test_rest import column
from tests.own_laws.with_laws import serving
from tests.server.live import API, until

pytestmark = pytest.mark.realtime
MOTION = {"scenario": "circle", "variant": "B", "set": SHORT | LAW}


def test_it_moves_the_drive_and_knows_what_comes(tmp_path: Path) -> None:
    (tmp_path / "preview.py").write_text(TEXT)
    data = tmp_path / "data"
    data.mkdir()
    with VirtualDrive(priority=70, slow=SLOW) as drive:
        file = link_file(drive, tmp_path, slow=SLOW)
        with serving(tmp_path, data, "--drive", str(file)) as client:
            moved(client)


def moved(client: httpx.Client) -> None:
    until(lambda: client.get(DRIVE).json()["step"] not in {"", "compiling"})
    with Operator(client) as operator:
        operator.arm()
        session = ended(client, operator.begin(MOTION))
    assert session["state"] == "finished", client.get(DRIVE).json()["fault"]
    run = kept(client, session["run"])
    assert 0 < run["metrics"]["B.x.max_abs_following_error"] < 100e-6
    names = ("law_phase", "law_p_1", "law_p_2")
    query = {"format": "csv", "columns": ",".join(f"B.x.{name}" for name in names)}
    query["columns"] += ",x.position_reference"
    text = client.get(f"{API}/runs/{run['id']}/telemetry", params=query).raise_for_status().text
    phase, one, two = (column(text, f"B.x.{name}") for name in names)
    reference = column(text, "x.position_reference")
    assert phase.min() == 0.0 and 0.999 < phase.max() < 1.0
    np.testing.assert_array_equal(one[:-1], reference[1:])
    np.testing.assert_array_equal(two[:-2], reference[2:])
