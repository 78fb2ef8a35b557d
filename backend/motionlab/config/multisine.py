"""A motion that tells a frequency response: slides to and fro under a sum of sines."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import model_validator

from motionlab.config.moves import OURS
from motionlab.config.planar import PlanarLength
from motionlab.config.quantity import Config, quantity
from motionlab.timing import CONTROL_PERIOD

NYQUIST = 0.5 / CONTROL_PERIOD
LINES_MAX = 1000
Signal = Literal["multisine", "noise", "chirp", "stepped-sine"]
SIGNAL = (
    "What is added to the slides, periodic: sines with random phases; noise, and a chirp that "
    "rises from low to high, of all whole cycles of a period; or one sine after the other"
)


class Multisine(Config):
    """Slide to and fro at constant velocity under a multisine, for a frequency response.

    Each slide draws the phases of its sines anew. A sine of frequency f has the amplitude
    ``a sqrt(2/lines) sqrt(1 + (f/corner)^2) / (2 pi f)^2``, a being `acceleration`, and at most
    what changes the velocity of the slide, all sines together, by a tenth RMS.
    """

    kind: Literal["multisine"] = "multisine"
    signal: Signal = quantity(SIGNAL, unit="", source=OURS, default="multisine")
    axis: Literal["x", "y"] = quantity(
        "Axis that slides and is shaken", unit="", source=OURS, default="x"
    )
    center: PlanarLength = quantity(
        "Middle of the slides",
        label="centre",
        shown="mm",
        unit="m",
        source=OURS,
        default=PlanarLength(),
    )
    velocity: float = quantity(
        "Velocity of the slides",
        shown="mm/s",
        unit="m/s",
        source=f"{OURS}: at rest the bristles of friction answer, not the machine",
        default=0.04,
        gt=0,
        le=0.2,
    )
    acceleration: float = quantity(
        "Acceleration of all sines below the corner, RMS",
        unit="m/s^2",
        source=f"{OURS}: a force of 2 N moves 10 kg so",
        default=0.2,
        gt=0,
        le=20,
    )
    corner: float = quantity(
        "Frequency above which the sines keep their velocity, not their acceleration: without "
        "acceleration feedforward the command falls there",
        unit="Hz",
        source=OURS,
        default=200.0,
        ge=1,
        le=NYQUIST,
    )
    low: float = quantity(
        "Lowest frequency; its period is that of the multisine",
        unit="Hz",
        source=OURS,
        default=1.0,
        ge=0.2,
        le=50,
    )
    high: float = quantity(
        "Highest frequency", unit="Hz", source=OURS, default=700.0, ge=10, le=0.95 * NYQUIST
    )
    lines: int = quantity(
        "Frequencies, evenly over their logarithm; noise and a chirp have all there are, and a "
        "response at so many of them",
        unit="1",
        source=OURS,
        default=60,
        ge=8,
        le=LINES_MAX,
    )
    periods: int = quantity(
        "Periods that are measured in a slide; another half second before them settles",
        unit="1",
        source=OURS,
        default=2,
        ge=2,
        le=100,
    )
    slides: int = quantity(
        "Slides to and fro, one after another", unit="1", source=OURS, default=14, ge=5, le=500
    )
    seed: int = quantity("Of the phases", unit="1", source=OURS, default=0, ge=0, le=2**31 - 1)
    for_ever: bool = quantity(
        "Whether a live session repeats it for ever",
        label="for ever",
        unit="",
        source=OURS,
        default=False,
    )

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.high < 2.0 * self.low:
            raise ValueError(f"high must be at least twice low; got {self.high:g} and {self.low:g}")
        if self.for_ever and self.slides % 2:
            raise ValueError(
                "for_ever needs an even number of slides, or it does not end where it begins; "
                f"got {self.slides}"
            )
        if self.signal == "stepped-sine" and self.slides < 2 * self.lines:
            raise ValueError(
                f"slides must be at least {2 * self.lines}, two for each of {self.lines} lines of "
                f"a stepped sine; got {self.slides}"
            )
        return self
