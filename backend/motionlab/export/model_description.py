"""Variables of an exported plant, and the modelDescription.xml of FMI 3.0 that lists them."""

from __future__ import annotations

import typing
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Literal
from xml.etree import ElementTree as ET

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from motionlab import __version__
from motionlab.config.force_map import TableMapConfig
from motionlab.config.planar import AXES
from motionlab.config.plant import AxisConfig, PlantConfig
from motionlab.config.validation_errors import bounds_of, strip, unit_of_field
from motionlab.motor_design.kept_maps import named_map
from motionlab.telemetry.channels import CHANNELS
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP

MODEL_IDENTIFIER = "psrm_plant"

PHASES = ("a", "b", "c")

_BASE_UNITS = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "s": {"s": 1},
    "kg": {"kg": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "N s/m": {"kg": 1, "s": -1},
    "A": {"A": 1},
    "Hz": {"s": -1},
}
_SIMULATION_ONLY = {
    "velocity_max",
    "acceleration_max",
    "ripple_amplitude",
    "ripple_frequency",
    "noise",
    "interface_rate",
}
"""Fields of an axis that limit trajectories, or describe noise, which is the importer's."""

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

Causality = Literal["independent", "input", "output", "parameter", "local"]


@dataclass(frozen=True)
class Variable:
    """One variable of the unit; its place in the list is its value reference.

    Attributes
    ----------
    name : str
        Such as ``x.friction.F_c``.
    member : str
        Its place in the C struct psrm_memory.
    description : str
        What it is.
    unit : str
        SI unit; ``1`` for a pure number, empty for a switch.
    causality : str
        As in FMI 3.0; a ``local`` one is constant.
    start : float or bool, optional
        Value before the first step; none of what is computed.
    bounds : dict of str to float
        Ends of the allowed range by `motionlab.errors.SIGNS`.
    fixed : bool
        Whether a parameter cannot be changed after the first step.
    depends_on : str
        The input that an output follows at once, if there is one.
    """

    name: str
    member: str
    description: str
    unit: str
    causality: Causality
    start: float | bool | None = None
    bounds: dict[str, float] = field(default_factory=dict)
    fixed: bool = False
    depends_on: str = ""


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


def model_description(
    variables: Iterable[Variable], *, scenario: str, token: str, seconds: float
) -> bytes:
    """Return the modelDescription.xml of FMI 3.0.

    Parameters
    ----------
    variables : iterable of Variable
        In the order of their value references.
    scenario : str
        Name of the scenario.
    token : str
        Instantiation token, which the C has too.
    seconds : float
        Length of the scenario, s.
    """
    variables = list(variables)
    references = {variable.name: str(i) for i, variable in enumerate(variables)}
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=f"psrm_plant.{scenario}",
        instantiationToken=token,
        description=f"Planar switched reluctance motor of the scenario {scenario}, two axes",
        license="MIT",
        generationTool=f"motionlab {__version__}",
        variableNamingConvention="structured",
    )
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=MODEL_IDENTIFIER,
        needsExecutionTool="false",
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        fixedInternalStepSize=f"{PLANT_STEP:g}",
    )
    units = ET.SubElement(root, "UnitDefinitions")
    for unit in sorted({variable.unit for variable in variables} & set(_BASE_UNITS)):
        exponents = {base: str(power) for base, power in _BASE_UNITS[unit].items()}
        ET.SubElement(ET.SubElement(units, "Unit", name=unit), "BaseUnit", exponents)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError", description="what was refused")
    ET.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=f"{seconds:g}",
        stepSize=f"{CONTROL_PERIOD:g}",
    )
    listed = ET.SubElement(root, "ModelVariables")
    for variable in variables:
        listed.append(_element(variable, references[variable.name]))
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [variable for variable in variables if variable.causality == "output"]
    for kind in ("Output", "InitialUnknown"):
        for variable in outputs:
            entry = ET.SubElement(structure, kind, valueReference=references[variable.name])
            if kind == "Output":
                entry.set("dependencies", references.get(variable.depends_on, ""))
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _element(variable: Variable, reference: str) -> ET.Element:
    switch = isinstance(variable.start, bool)
    element = ET.Element(
        "Boolean" if switch else "Float64",
        name=variable.name,
        valueReference=reference,
        description=variable.description,
        causality=variable.causality,
    )
    match variable.causality:
        case "parameter":
            element.set("variability", "fixed" if variable.fixed else "tunable")
        case "local":
            element.set("variability", "constant")
        case "independent" | "input" | "output":
            element.set("variability", "continuous")
    if variable.causality == "output":
        element.set("initial", "calculated")
    if variable.start is not None:
        element.set("start", str(variable.start).lower() if switch else repr(variable.start))
    if variable.unit in _BASE_UNITS:
        element.set("unit", variable.unit)
    for attribute, kinds in (
        ("min", ("minimum", "exclusive_minimum")),
        ("max", ("maximum", "exclusive_maximum")),
    ):
        for kind in kinds:
            if kind in variable.bounds:
                element.set(attribute, repr(float(variable.bounds[kind])))
    return element
