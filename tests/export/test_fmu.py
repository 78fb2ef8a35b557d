"""``motionlab export-plant``: what the FMU holds, what importers do with it, refusals."""

from __future__ import annotations

import platform
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.model_description import read_build_description
from fmpy.validation import validate_fmu

from motionlab.cli import main
from motionlab.export.fmu import HEADERS
from tests.export.compilers import STRICT, built, call, compiler
from tests.export.unit import Unit
from tests.paths import ROOT

TABLE = ["--set", 'plant.y.force_map={kind="table", name="new-design"}']
PUSHED = {f"{axis}.current_command_b": 2.0 for axis in "xy"} | {"y.load_force": 1.5}
SANITIZED = ("-std=c99", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover")

IMPORTER = """\
#include <stdio.h>
#include <stdlib.h>
#include "fmi3Functions.h"

int main(int argc, char **argv)
{
    const fmi3ValueReference command = 1U;
    const fmi3ValueReference position = 6U;
    fmi3Instance unit = fmi3InstantiateCoSimulation(
        "motor", argv[1], NULL, false, false, false, false, NULL, 0U, NULL, NULL, NULL);
    fmi3FMUState state = NULL;
    fmi3FMUState other = NULL;
    fmi3Byte *bytes;
    fmi3Boolean ignored;
    fmi3Float64 value = 3.0;
    size_t size;
    int k;

    (void)argc;
    if (unit == NULL) {
        return 2;
    }
    (void)fmi3EnterInitializationMode(unit, false, 0.0, 0.0, false, 0.0);
    (void)fmi3ExitInitializationMode(unit);
    (void)fmi3SetFloat64(unit, &command, 1U, &value, 1U);
    for (k = 0; k < 2000; k++) {
        if (fmi3DoStep(unit, k * 7e-4, 7e-4, true, &ignored, &ignored, &ignored, &value) !=
            fmi3OK) {
            return 3;
        }
    }
    (void)fmi3GetFMUState(unit, &state);
    (void)fmi3SerializedFMUStateSize(unit, state, &size);
    bytes = malloc(size);
    (void)fmi3SerializeFMUState(unit, state, bytes, size);
    (void)fmi3DeserializeFMUState(unit, bytes, size, &other);
    (void)fmi3SetFMUState(unit, other);
    (void)fmi3FreeFMUState(unit, &state);
    (void)fmi3FreeFMUState(unit, &other);
    free(bytes);
    value = 0.0;
    (void)fmi3GetFloat64(unit, &position, 1U, &value, 1U);
    (void)fmi3Terminate(unit);
    fmi3FreeInstance(unit);
    (void)printf("%.6f", value);
    return 0;
}
"""


def exported(path: Path, *options: str) -> Path:
    assert main(["export-plant", "circle", "--out", str(path), *options]) == 0
    return path


@pytest.fixture(scope="module")
def motor(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an FMU with a formula on x and a table on y."""
    compiler("gcc")
    return exported(tmp_path_factory.mktemp("fmu") / "motor.fmu", *TABLE)


def pushed(unit: Unit, steps: int = 40, seconds: float = 5e-4) -> list[float]:
    """Return the outputs after some steps under constant currents."""
    unit.set(PUSHED)
    for _ in range(steps):
        unit.step(seconds)
    return unit.get(unit.outputs)


def test_the_validator_reports_nothing(motor: Path) -> None:
    """Schemas of both descriptions, names, structure and units of the variables."""
    assert validate_fmu(str(motor)) == []
    (configuration,) = read_build_description(str(motor), validate=True)
    with zipfile.ZipFile(motor) as archive:
        listed = {f"sources/{name}" for name in configuration.sourceFileSets[0].sourceFiles}
        names = set(archive.namelist())
        assert listed == {name for name in names if name.endswith(".c")}
        assert f"binaries/{platform.machine()}-linux/psrm_plant.so" in names
        licence = archive.read("documentation/licenses/license.txt")
    assert licence == (ROOT / "LICENSE").read_bytes()


def test_fmpy_simulates_it(motor: Path) -> None:
    start = PUSHED | {"x.friction.enabled": False, "x.position_start": 0.01}
    found: Any = fmpy.simulate_fmu(str(motor), stop_time=0.02, start_values=start)
    assert found["time"][-1] == pytest.approx(0.02)
    assert found["x.position"][0] == 0.01
    assert found["x.velocity"][-1] != 0.0
    assert np.abs(found["x.friction"]).max() < 1e-50 < np.abs(found["y.friction"]).max()
    assert found["x.current_b"][-1] == pytest.approx(2.0)


def test_a_load_presses_the_mover_against_an_end_stop(motor: Path) -> None:
    """The stop yields by the load over its stiffness."""
    unit = Unit(motor, {"x.friction.enabled": False, "x.position_start": -0.0859})
    unit.set({"x.load_force": 50.0})
    unit.step(1.0)
    position, velocity = unit.get(["x.position", "x.velocity"])
    assert position == pytest.approx(-0.085 - 1e-3 - 50.0 / 2e6, abs=1e-12)
    assert velocity == pytest.approx(0.0, abs=1e-12)


def test_the_same_motor_has_the_same_bytes(motor: Path, tmp_path: Path) -> None:
    again = exported(tmp_path / "again.fmu", *TABLE)
    assert again.read_bytes() == motor.read_bytes()


@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_sources_compile_without_a_warning(name: str, motor: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(motor) as archive:
        archive.extractall(tmp_path)
    sources = sorted((tmp_path / "sources").glob("*.c"))
    built(compiler(name), *STRICT, "-fsyntax-only", "-isystem", HEADERS, *sources)


def test_sanitizers_find_nothing(motor: Path, tmp_path: Path) -> None:
    """Steps of seven internal ones, a state that goes through bytes, and its release."""
    with zipfile.ZipFile(motor) as archive:
        archive.extractall(tmp_path)
    importer = tmp_path / "importer.c"
    importer.write_text(IMPORTER)
    sources = [importer, *sorted((tmp_path / "sources").glob("*.c"))]
    program = tmp_path / "importer"
    built(compiler("gcc"), *SANITIZED, f"-I{HEADERS}", *sources, "-lm", "-o", program)
    unit = Unit(motor)
    done = call(program, unit.description.guid)
    assert (done.returncode, done.stderr) == (0, "")
    unit.set({"x.current_command_a": 3.0})
    for _ in range(2000):
        unit.step(7e-4)
    assert done.stdout == f"{unit.get(['x.position'])[0]:.6f}"


def test_a_parameter_that_is_set_is_as_good_as_one_exported(motor: Path, tmp_path: Path) -> None:
    changes = {
        "plant.x.mass": 7.0,
        "plant.x.friction.F_s": 3.0,
        "plant.x.friction.sigma_1": 900.0,
        "plant.x.force_map.F_pk": 30.0,
        "plant.x.force_map.h_3": 0.03,
        "plant.x.amplifiers.bandwidth": 300.0,
        "plant.x.encoder.resolution": 1e-6,
        "plant.x.resonance.coupling": 2.0,
        "plant.y.force_map.gain": 0.8,
        "plant.y.force_map.offset": 1e-4,
        "plant.y.amplifiers.limit": 1.5,
    }
    sets = [word for path, value in changes.items() for word in ("--set", f"{path}={value}")]
    other = Unit(exported(tmp_path / "other.fmu", *TABLE, *sets))
    values = {path.removeprefix("plant."): value for path, value in changes.items()}
    nominal = pushed(Unit(motor))
    assert other.description.guid != Unit(motor).description.guid
    assert pushed(other) != nominal
    assert pushed(Unit(motor, values)) == pushed(Unit(tmp_path / "other.fmu"))
    tuned = Unit(motor)
    tuned.set(values)  # in its step mode
    assert pushed(tuned) == pushed(Unit(motor, values))
    tuned.fmu.reset()
    tuned.initialise()
    assert pushed(tuned) == nominal


def test_a_state_is_restored_from_bytes(motor: Path) -> None:
    unit = Unit(motor)
    pushed(unit)
    state = unit.fmu.getFMUState()
    content = unit.fmu.serializeFMUState(state)
    wanted = pushed(unit)
    unit.fmu.setFMUState(state)
    assert pushed(unit) == wanted
    unit.fmu.freeFMUState(state)
    other = Unit(motor)
    restored = other.fmu.deserializeFMUState(content)
    other.fmu.setFMUState(restored)
    other.fmu.freeFMUState(restored)
    assert pushed(other) == wanted


def test_communication_steps_of_any_length(motor: Path) -> None:
    """Multiples of the internal step give equal bits; a rest becomes a shorter step."""
    wanted = pushed(Unit(motor), 40, 5e-4)
    assert pushed(Unit(motor), 200, 1e-4) == wanted
    finer = pushed(Unit(motor), 400, 5e-5)
    uneven = pushed(Unit(motor), 125, 1.6e-4)
    place = Unit(motor).outputs.index("y.position")
    travelled = abs(wanted[place] - Unit(motor).get(["y.position"])[0])
    assert travelled > 1e-5
    for found in (finer, uneven):
        assert found != wanted
        assert found[place] == pytest.approx(wanted[place], abs=1e-3 * travelled)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"x.mass": 0.0}, "x.mass = 0 is not from 0.001 to 1000"),
        ({"x.friction.v_s": 1e-5}, "x.friction.v_s = 1e-05 is not from 1e-05 (excluded) to 10"),
        ({"x.current_command_a": float("nan")}, "x.current_command_a = nan"),
        ({"x.load_force": float("inf")}, "x.load_force = inf"),
        ({"y.amplifiers.limit": 99.0}, "y.amplifiers.limit = 99"),
        ({"x.position_start": 0.0}, "x.position_start cannot be set now"),
        ({"x.position": 0.0}, "x.position cannot be set now"),
        ({"y.force_map.tau": 0.01}, "y.force_map.tau cannot be set now"),
        ({"x.mass": True}, "value reference"),
    ],
)
def test_values_that_are_refused(values: dict[str, Any], message: str, motor: Path) -> None:
    unit = Unit(motor)
    with pytest.raises(FMICallException):
        unit.set(values)
    assert unit.messages[-1].startswith(message)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"y.friction.F_c": 50.0}, "axis y: friction.F_s is below friction.F_c"),
        ({"x.mass": 0.1}, "axis x: mass is too small for stop_damping"),
        ({"x.friction.sigma_1": 1e6}, "axis x: mass is too small for friction.sigma_1"),
    ],
)
def test_parameters_that_do_not_fit_are_refused(
    values: dict[str, Any], message: str, motor: Path
) -> None:
    unit = Unit(motor, values, initialised=False)
    with pytest.raises(FMICallException):
        unit.initialise()
    assert unit.messages[-1].startswith(message)
    later = Unit(motor)
    later.set(values)
    with pytest.raises(FMICallException):
        later.step(5e-4)


def test_another_motors_binary_is_refused(motor: Path) -> None:
    unit = Unit(motor)
    unit.fmu.guid = "{00000000-0000-0000-0000-000000000000}"
    said: list[bytes] = []
    with pytest.raises(Exception, match="instantiate"):
        unit.fmu.instantiate(logMessage=lambda *given: said.append(given[-1]))
    assert b"instantiation token" in said[0]


def test_without_a_compiler_it_says_that_there_is_no_binary(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("CC", "")
    monkeypatch.setenv("PATH", str(tmp_path))
    path = exported(tmp_path / "sources.fmu")
    assert "sources only: there is no C compiler" in capsys.readouterr().out
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    assert not any(name.startswith("binaries/") for name in names)
    assert {"modelDescription.xml", "sources/psrm_plant.c"} <= set(names)


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        ("false", "false cannot compile the unit: exit code 1"),
        ("no-such-compiler", "no-such-compiler cannot compile the unit: "),
        ("gcc -DPSRM_FMI3_H", "error: "),
    ],
)
def test_a_compiler_that_fails_is_an_error(
    command: str,
    reason: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    compiler("gcc")
    monkeypatch.setenv("CC", command)
    path = tmp_path / "motor.fmu"
    assert main(["export-plant", "circle", "-o", str(path)]) == 1
    assert reason in capsys.readouterr().err
    assert not path.exists()


@pytest.mark.parametrize(
    ("file", "options", "message"),
    [
        ("motor.fmu", ["--set", "plant.force=ideal"], "plant.force: has no phases"),
        ("motor.zip", [], "--out"),
        ("none/motor.fmu", [], "--out"),
        (
            "motor.fmu",
            ["--set", 'plant.x.force_map={kind="table", name="no-such"}'],
            "plant.x.force_map",
        ),
    ],
)
def test_refusals(
    file: str,
    options: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["export-plant", "circle", "--out", str(tmp_path / file), *options]) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
