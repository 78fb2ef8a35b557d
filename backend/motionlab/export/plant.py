"""Writing a scenario's motor as an FMU: FMI 3.0 for co-simulation, in C99."""

from __future__ import annotations

from pathlib import Path

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.export.fmu import UnitExport, export_unit
from motionlab.export.model_description import Model
from motionlab.export.plant_code import plant_code
from motionlab.export.plant_variables import variables_of
from motionlab.files import check_target
from motionlab.simulation.prepare import prepare
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP

PLANT_SOURCE = Path(__file__).with_name("plant_source")
"""The motor's files, and templates (.in)."""

MODEL_IDENTIFIER = "psrm_plant"


def export_plant(scenario: Scenario, path: Path) -> UnitExport:
    """Write the motor of a scenario as an FMU.

    It has sources, and a binary for this platform where a C compiler is found: that of the
    environment's CC, else cc, gcc or clang. Equal scenarios and compilers give equal bytes.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario; exported is the motor that it begins with, without noise.
    path : Path
        File to write, ``.fmu``.

    Raises
    ------
    ConfigError
        If the motor has no phases or has effects, a force map is not there, or the file cannot be.
    Infeasible
        If the motor cannot follow the trajectory, at whose start it stands.
    MotionLabError
        If a compiler is there and fails.
    StoreError
        If the file cannot be written.
    """
    check_target(str(path), ".fmu")
    if scenario.plant.force != "phases":
        raise ConfigError(
            FieldError(
                "plant.force", "has no phases, whose currents an FMU takes", "ideal", "phases"
            )
        )
    for axis in AXES:
        if effects := getattr(scenario.plant, axis).effects:
            raise ConfigError(
                FieldError(
                    f"plant.{axis}.effects",
                    "cannot be exported: an FMU has the motor's own friction alone",
                    ", ".join(each.effect for each in effects),
                    "none",
                )
            )
    reference = prepare(scenario).reference
    x, y = reference.position[0]
    model = Model(
        MODEL_IDENTIFIER,
        f"Planar switched reluctance motor of the scenario {scenario.name}, two axes",
        PLANT_STEP,
        any_step=True,
        seconds=reference.ticks * CONTROL_PERIOD,
    )
    return export_unit(
        path,
        model,
        variables_of(scenario.plant, (float(x), float(y))),
        scenario=scenario,
        templates=PLANT_SOURCE.iterdir(),
        facts=plant_code(scenario)._asdict(),
    )
