"""``motionlab tune``, ``POST /tune``, ``/landscape``, the loop over frequency: what they answer."""

from __future__ import annotations

import json
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.loop.linearise import SLIDING, linearise
from motionlab.loop.steady_state_error import crossover, sine_error
from motionlab.studies.tune.documents import LandscapeDocument, TuneDocument
from tests.server.live import API, until

SHORT: dict[str, Any] = {"trajectory.frequency": 2.0, "trajectory.radius": 0.002}
SET = [f"--set={path}={value}" for path, value in SHORT.items()]
COMMAND = ["tune", "circle", *SET, "--axis", "x", "--starts", "2", "--evaluations", "30"]
BODY: dict[str, Any] = {"set": SHORT, "axis": "x", "starts": 2, "evaluations": 30}


def done(client: httpx.Client, path: str, body: dict[str, Any]) -> dict[str, Any]:
    """Return the report of a job that has ended."""
    response = client.post(f"{API}{path}", json=body)
    assert response.status_code == 202, response.text
    location = response.headers["location"]
    until(lambda: client.get(location).json()["state"] in {"done", "failed"})
    report = client.get(location).json()
    assert report["error"] is None
    return report


def test_the_job_ends_with_what_the_command_prints(
    client: httpx.Client, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*COMMAND, "--json"]) == 0
    streams = capsys.readouterr()
    document = json.loads(streams.out)
    assert "tuning 0 %" in streams.err
    report = done(client, "/tune", BODY)
    assert report["kind"] == "tune"
    assert report["result"] == document
    found = TuneDocument.model_validate(document)
    assert found.evaluations == sum(len(start.cost) for g in found.groups for start in g.starts)
    # what is found can be put to use as it is
    scenario = load_scenario("circle", SHORT | found.set)
    assert scenario.variants["B"].controller.x.k_p == found.groups[0].candidates[0].axes["x"].k_p
    # what the simplex did so far stays with the job
    starts = report["partial"]["groups"][0]["starts"]
    history = document["groups"][0]["starts"][0]["cost"]
    assert starts[0]["cost"] == history[: len(starts[0]["cost"])]


def test_the_text_names_gains_margins_and_why_each_start_ended(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(COMMAND) == 0
    text = capsys.readouterr().out
    for word in ("x present", "x paper", "x start 0", "evaluations", "--set variants.B.controller"):
        assert word in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bounds", "k_p=1e6:1e5"], ["bounds.k_p", "1e+06 to 100000"]),
        (["--bounds", "k_p=1e6"], ["bounds.k_p", "LOW:HIGH"]),
        (["--bounds", "k_p"], ["--bounds", "GAIN=LOW:HIGH", "'k_p'"]),
        (["--bounds", "k_p=1:2", "--bounds", "k_p=1:3"], ["--bounds", "k_p twice", "'1:3'"]),
        (["--objective", "rms,rms=2"], ["--objective", "rms twice"]),
        (["--objective", "speed"], ["objective.speed", "one of peak, rms, itae, settling, effort"]),
        (["--objective", "peek"], ["objective.peek", "did you mean 'peak'?"]),
        (["--objective", "rms=often"], ["objective.rms", "often"]),
        (["--constraint", "phase_margin=9"], ["constraints.phase_margin", "rad"]),
        (["--starts", "99"], ["starts", "99", "16"]),
        (["--variant", "Q"], ["variant", "Q"]),
        (["--plants", "nowhere"], ["plant", "nowhere"]),
        (["--also", "feedforward=1:2"], ["also.feedforward", "one of compensation.bristle_limit"]),
    ],
)
def test_bad_options_are_refused_by_name(
    arguments: list[str], words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["tune", *arguments]) == 2
    streams = capsys.readouterr()
    assert streams.out == ""
    for word in words:
        assert word in streams.err


def test_an_unstable_set_is_named_with_its_limit(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*COMMAND, "--set", "variants.B.controller.x.k_p=6e6"]) == 0
    text = capsys.readouterr().out
    assert "warning: the present gains are unstable" in text
    assert "k_p = 6e+06 N/m (the stability boundary, moved alone:" in text


def test_a_landscape_job_tells_a_coarse_map_first(client: httpx.Client) -> None:
    report = done(client, "/landscape", {"set": SHORT, "points": 16})
    found = LandscapeDocument.model_validate(report["result"])
    assert list(found.axes) == ["x", "y"]
    assert report["partial"]["axes"]["x"]["stride"] == 2
    for axis in found.axes.values():
        assert axis.stride == 1
        assert np.array(axis.cost).shape == (16, 16)
        assert len(axis.edge) >= 1
    assert found.axes["x"].present == (200300.0, 1530.0)


@pytest.mark.parametrize("path", ["/tune", "/landscape"])
def test_a_job_is_cancelled_and_keeps_what_it_had(client: httpx.Client, path: str) -> None:
    long: dict[str, Any] = {"window": {"start": 1.0, "end": 10.0}}
    long |= {"evaluations": 2000, "starts": 8} if path == "/tune" else {"points": 128}
    response = client.post(f"{API}{path}", json=long)
    location = response.headers["location"]
    until(lambda: client.get(location).json()["partial"] is not None)
    assert client.delete(location).json()["state"] == "cancelled"
    report = client.get(location).json()
    assert report["result"] is None
    assert report["partial"] is not None
    # the next job does not wait for it
    done(client, "/tune", BODY | {"starts": 1, "evaluations": 10})


@pytest.mark.parametrize(
    ("path", "body", "loc"),
    [
        ("/tune", {"bounds": {"k_d": [5.0, 5.0]}}, "bounds.k_d"),
        ("/tune", {"objective": {"settling": 1.0}}, "objective.settling"),
        ("/tune", {"scenario": "fig5", "window": {"start": 1.0, "end": 400.0}}, "window.end"),
        ("/tune", {"evaluations": 2000, "scenario": "fig5"}, "scenario"),
        ("/landscape", {"points": 1000}, "points"),
        ("/landscape", {"axis": "z"}, "axis"),
        ("/loop/response", {"axis": "both"}, "axis"),
        ("/loop/response", {"scenario": "circle-published-k"}, "variants.B.controller"),
        ("/loop/accuracy", {"variant": "C"}, "variant"),
        ("/loop/sweep", {"frequencies": [5000.0]}, "frequencies.0"),
        ("/loop/sweep", {"scenario": "circle-published-k"}, "variants.B.controller"),
    ],
)
def test_a_bad_request_is_refused_by_field(
    client: httpx.Client, path: str, body: dict[str, Any], loc: str
) -> None:
    response = client.post(f"{API}{path}", json=body)
    assert response.status_code == 422
    assert response.json()["errors"][0]["loc"].startswith(loc)


def test_the_response_is_that_of_the_linearised_loop(client: httpx.Client) -> None:
    answer = client.post(f"{API}/loop/response", json={"variant": "B", "axis": "y"}).json()
    scenario = load_scenario("circle")
    v = SLIDING * scenario.plant.y.friction.v_s
    L = linearise(scenario, "B", "y", v=v).open(np.array(answer["frequency"]))
    for name, exact in (("open", L), ("closed", L / (1 + L)), ("sensitivity", 1 / (1 + L))):
        curve = answer[name]
        told = np.array(curve["magnitude"]) * np.exp(1j * np.array(curve["phase"]))
        np.testing.assert_allclose(told, exact, rtol=1e-4)
        assert np.abs(np.diff(curve["phase"])).max() < np.pi
    assert -1.5 * np.pi < answer["open"]["phase"][0] < -0.5 * np.pi


def test_a_sweep_finds_the_linearised_loop_at_its_velocity(client: httpx.Client) -> None:
    report = done(client, "/loop/sweep", {"frequencies": [10.0, 50.0], "axis": "x"})
    swept = report["result"]
    assert swept["velocity"] == 0.02
    linear = swept["linearised"]
    assert linear["velocity"] == 0.02
    for k, frequency in enumerate(swept["frequency"]):
        exact = np.interp(frequency, linear["frequency"], linear["open"]["magnitude"])
        assert swept["open"]["magnitude"][k] == pytest.approx(exact, rel=0.03)
        phase = np.interp(frequency, linear["frequency"], linear["open"]["phase"])
        assert swept["open"]["phase"][k] == pytest.approx(phase, abs=0.06)


def test_the_equations_stand_beside_the_simulation(client: httpx.Client) -> None:
    answer = client.post(f"{API}/loop/accuracy", json={"variant": "B", "axis": "x"}).json()
    M, k_p, k_d, w = 5.9, 200300.0, 1530.0, 2 * np.pi / 3
    assert answer["crossover"] == pytest.approx(crossover(M, k_p, k_d) / (2 * np.pi))
    sine = answer["sine"]
    assert sine["amplitude"] == pytest.approx(0.015, rel=1e-6)
    promised = sine_error(M, k_p, k_d, B=sine["amplitude"], w=w)
    assert sine["predicted"] == pytest.approx(promised.amplitude)
    assert sine["predicted_phase"] == pytest.approx(promised.phase)
    assert answer["parabola"] == pytest.approx(M * answer["acceleration"] / k_p)
    # a mass without friction keeps the promise; the compensated motor nearly, PD alone does not
    assert sine["ideal"] == pytest.approx(sine["predicted"], rel=0.01)
    assert sine["ideal_phase"] == pytest.approx(sine["predicted_phase"], abs=0.01)
    assert sine["simulated"] == pytest.approx(sine["predicted"], rel=0.02)
    bare = client.post(f"{API}/loop/accuracy", json={"variant": "A", "axis": "x"}).json()
    assert bare["sine"]["simulated"] > 5 * sine["predicted"]
    assert bare["simulated_peak"] == pytest.approx(20.5e-6, rel=0.01)


def test_a_motion_that_does_not_repeat_has_no_sine(client: httpx.Client) -> None:
    body = {"scenario": "stair-x-500nm", "axis": "x"}
    assert client.post(f"{API}/loop/accuracy", json=body).json()["sine"] is None
