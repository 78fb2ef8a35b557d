"""Variables of an exported motor."""

from __future__ import annotations

import typing
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from motionlab.config.force_map import TableMapConfig
from motionlab.config.planar import AXES
from motionlab.config.plant import AxisConfig, PlantConfig
from motionlab.config.validation_errors import bounds_of, strip, unit_of_field
from motionlab.export.model_description import PHASES, Variable
from motionlab.motor_design.kept_maps import named_map
from motionlab.telemetry.channels import CHANNELS

_SIMULATION_ONLY = {
    "velocity_max",
    "acceleration_max",
    "ripple_amplitude",
    "ripple_frequency",
    "noise",
    "jitter",
    "interface_rate",
    "effects",
}
"""Fields of an axis that limit trajectories, or describe noise, which is the importer's.

A motor with effects is not exported."""

_MEMBERS = {
    "friction.enabled": "friction_on",
    "force_map.gain": "map_gain",
}
"""Fields that psrm_plant.h keeps elsewhere than the scenario does."""

_OUTPUTS = {
    "position",
    "position_measured",
    "velocity",
    "friction",
    "bristle",
    "thrust",
    "normal_force",
    "current_a",
    "current_b",
    "current_c",
}


def variables_of(plant: PlantConfig, start: tuple[float, float]) -> list[Variable]:
    """Return the variables of a motor in the order of their value references.

    Parameters
    ----------
    plant : PlantConfig
        Motor with phases.
    start : tuple of float
        Position of x and y at the start, m.

    Raises
    ------
    ConfigError
        If a force map is not there, or cannot be read.
    """
    variables = [Variable("time", "time", "time", "s", "independent")]
    for index, axis in enumerate(AXES):
        variables += _inputs(index, axis)
        variables += _outputs(index, axis)
        variables += _axis_parameters(index, axis, getattr(plant, axis))
        variables.append(
            Variable(
                f"{axis}.position_start",
                f"par[{index}].position_start",
                "position at rest at the start",
                "m",
                "parameter",
                start=start[index],
                bounds={"minimum": -1.0, "maximum": 1.0},
                fixed=True,
            )
        )
    return variables


def _inputs(index: int, axis: str) -> Iterator[Variable]:
    for phase in PHASES:
        yield Variable(
            f"{axis}.current_command_{phase}",
            f"in[{index}].current.{phase}",
            f"current command of phase {phase}",
            "A",
            "input",
            start=0.0,
        )
    described = "external load force f_d; pushes towards negative positions"
    yield Variable(f"{axis}.load_force", f"in[{index}].load", described, "N", "input", start=0.0)
    described = "noise of the encoder, added before it rounds to counts"
    noise = f"in[{index}].encoder_noise"
    yield Variable(f"{axis}.encoder_noise", noise, described, "m", "input", start=0.0)


def _outputs(index: int, axis: str) -> Iterator[Variable]:
    for channel in CHANNELS:
        if channel.name in _OUTPUTS:
            yield Variable(
                f"{axis}.{channel.name}",
                f"out[{index}].{channel.name}",
                channel.meaning,
                channel.unit,
                "output",
                depends_on=f"{axis}.encoder_noise" if channel.name == "position_measured" else "",
            )


def _axis_parameters(index: int, axis: str, config: AxisConfig) -> Iterator[Variable]:
    member, force_map = f"par[{index}].", config.force_map
    for variable in _parameters(config, member):
        changed: dict[str, Any] = {}
        if variable.name == "amplifiers.bandwidth":
            changed = {
                "start": variable.start or 0.0,
                "bounds": {"minimum": 0.0, "maximum": variable.bounds["maximum"]},
                "description": "Bandwidth of the current loops; 0: currents follow at once",
            }
        if variable.name == "amplifiers.limit" and isinstance(force_map, TableMapConfig):
            reach = named_map(force_map.name).i_max
            changed = {"bounds": variable.bounds | {"maximum": reach}}
        yield replace(variable, name=f"{axis}.{variable.name}", **changed)
    if isinstance(force_map, TableMapConfig):
        tau, described = named_map(force_map.name).tau, f"pole pitch of {force_map.name}"
        place = f"{member}force_map.tau"
        yield Variable(f"{axis}.force_map.tau", place, described, "m", "local", start=tau)


def _parameters(config: BaseModel, member: str, path: str = "") -> Iterator[Variable]:
    """Yield the numbers and switches of a table of the motor, and of the tables in it."""
    for name, info in type(config).model_fields.items():
        value, below = getattr(config, name), path + name
        if name in _SIMULATION_ONLY or isinstance(value, str):
            continue
        unit = unit_of_field(info)
        described = info.description or ""
        if isinstance(value, BaseModel):
            yield from _parameters(value, member, f"{below}.")
        elif isinstance(value, tuple):
            each = FieldInfo.from_annotation(typing.get_args(strip(info.annotation))[0])
            described = described.partition(", phases")[0]
            for number, phase in enumerate(PHASES):
                yield Variable(
                    f"{below}_{phase}",
                    f"{member}{below}_{phase}",
                    f"{described}, phase {phase}",
                    unit,
                    "parameter",
                    start=value[number],
                    bounds=bounds_of(each),
                )
        else:
            yield Variable(
                below,
                member + _MEMBERS.get(below, below),
                described,
                unit,
                "parameter",
                start=value,
                bounds=bounds_of(info),
            )
