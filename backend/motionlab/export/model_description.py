"""Variables of an exported unit, and the modelDescription.xml of FMI 3.0 that lists them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal
from xml.etree import ElementTree as ET

from motionlab import __version__
from motionlab.timing import CONTROL_PERIOD

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
    "1/s": {"s": -1},
    "m/s^2": {"m": 1, "s": -2},
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


@dataclass(frozen=True)
class Model:
    """What a unit is.

    Attributes
    ----------
    identifier : str
        Name of its binary.
    description : str
        In a sentence.
    step : float
        Internal step, s.
    any_step : bool
        Whether communication steps may have any length.
    seconds : float
        Length of the scenario, s.
    """

    identifier: str
    description: str
    step: float
    any_step: bool
    seconds: float


def model_description(
    model: Model, variables: Iterable[Variable], *, scenario: str, token: str
) -> bytes:
    """Return the modelDescription.xml of FMI 3.0.

    Parameters
    ----------
    model : Model
        What the unit is.
    variables : iterable of Variable
        In the order of their value references.
    scenario : str
        Name of the scenario.
    token : str
        Instantiation token, which the C has too.
    """
    variables = list(variables)
    references = {variable.name: str(i) for i, variable in enumerate(variables)}
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=f"{model.identifier}.{scenario}",
        instantiationToken=token,
        description=model.description,
        license="MIT",
        generationTool=f"motionlab {__version__}",
        variableNamingConvention="structured",
    )
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.identifier,
        needsExecutionTool="false",
        canHandleVariableCommunicationStepSize=str(model.any_step).lower(),
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        fixedInternalStepSize=f"{model.step:g}",
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
        stopTime=f"{model.seconds:g}",
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
