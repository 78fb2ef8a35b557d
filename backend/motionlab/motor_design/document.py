"""The document of a design: every quantity as the paper prints it and as it is used."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from motionlab.motor_design.inputs import Dimensions, Requirements, SizedDimensions
from motionlab.motor_design.presets import PresetName


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Reading(_Document):
    """One quantity, as printed in the paper and as used here."""

    quantity: str = Field(description="What it is, with its symbol")
    equation: str = Field(description="Number in the paper; empty where the paper has none")
    printed_form: str = Field(description="Formula as the paper prints it; empty where it has none")
    used_form: str = Field(description="Formula that gave `value`")
    printed_value: float | None = Field(
        description="What the printed formula gives; where the paper prints a number without "
        "formula that number, and null when the inputs are not the paper's"
    )
    value: float | None = Field(description="What is used, SI; null where there is none")
    unit: str = Field(description="Unit of both values; 1 for a pure number")
    remark: str = Field(description="Why the two differ; empty where they do not")


class Sizing(_Document):
    """From requirements to dimensions."""

    P_max: Reading
    tau: Reading
    sigma: Reading
    w: Reading
    N: Reading
    A: Reading
    K_1: Reading
    K_2: Reading
    A_g: Reading
    l_m: Reading
    lambda_needed: Reading
    psi: Reading
    dt: Reading
    u: Reading
    dimensions: SizedDimensions = Field(
        description="The dimensions found; design takes them as they are"
    )
    warnings: list[str]


class AxisRating(_Document):
    """Limits of one axis without friction."""

    acceleration: Reading
    velocity_single_phase: Reading
    velocity_two_phase: Reading
    velocity_two_phase_rest_to_rest: Reading
    mass_for_printed_velocity: Reading


class Rating(_Document):
    """From dimensions to limits."""

    P_specified: Reading
    w: Reading
    A_g: Reading
    A: Reading
    N_needed: Reading
    B_g_reached: Reading
    K_1: Reading
    K_2: Reading
    lambda_needed: Reading
    psi: Reading
    L_a: Reading
    L_u: Reading
    dt: Reading
    dpsi: Reading
    u: Reading
    P_max: Reading
    f_max: Reading
    x: AxisRating
    y: AxisRating
    warnings: list[str]


class DesignDocument(_Document):
    """Both directions; the same as ``motionlab design --json`` prints."""

    preset: PresetName
    title: str
    notes: list[str] = Field(description="What a reader has to know of the preset")
    requirements: Requirements = Field(description="As used, whatever was left out filled in")
    sizing: Sizing = Field(description="From requirements to dimensions")
    dimensions: Dimensions | None = Field(
        description="As used; null where the preset has none and none were given"
    )
    rating: Rating | None = Field(description="From dimensions to limits; null without dimensions")
