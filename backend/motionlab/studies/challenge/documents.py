"""The document of the challenge, and its report as text."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.quantity import si
from motionlab.reports.tables import table
from motionlab.studies.challenge.score import Verdict


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class AxisDocument(_Document):
    """One axis of one law in one scenario, over the window of its metrics."""

    max_error: float = si("Largest following error", "m")
    rms_error: float = si("RMS of the following error", "m")
    rms_force: float = si("RMS of the force command", "N")
    rms_force_change: float = si("RMS of its change from one control period to the next", "N")


class MotorsDocument(_Document):
    """One law in one scenario on the drawn motors; ratios to `off` on the same motor."""

    ratios: list[float | None] = Field(description="By motor; null where it diverged or none was")
    median: float | None
    q95: float | None = Field(description="95 % of the motors are below")
    diverged: int = Field(description="Motors on which it diverged")
    left_out: int = Field(description="Motors that cannot follow, or on which off diverged")


class ScenarioDocument(_Document):
    """One law in one scenario."""

    axes: dict[str, AxisDocument] | None = Field(description="By axis; null where it diverged")
    error: float | None = Field(description="Relative to off")
    effort: float | None = Field(description="Relative to off")
    motors: MotorsDocument | None = Field(description="null of a scenario without drawn motors")


class MarginDocument(_Document):
    """The least value of a margin over motors, axes and velocities."""

    value: float | None = Field(description="Factor, or rad; null where nothing crosses")
    motor: str
    axis: str
    velocity: float = si("0 at standstill", "m/s")


class LawDocument(_Document):
    """One law of the challenge."""

    rank: int
    law: str
    label: str = Field(description="Its name, and parameters that were set")
    description: str
    parameters: dict[str, Any] = Field(description="Those that were set")
    shipped: bool = Field(description="Whether it is a shipped law as it is declared")
    entered: bool = Field(description="Whether it was named")
    source: str | None = Field(description="SHA-256 of the file of a law of one's own")
    verdict: Verdict
    reasons: list[str] = Field(description="Why it does not hold; empty if it does")
    score: float | None = Field(description="null where a part is missing")
    error: float | None = Field(description="Geometric mean over the scenarios")
    motors: float | None = Field(description="Geometric mean of the error over drawn motors")
    effort: float | None = Field(description="Geometric mean over the scenarios")
    gain_margin: MarginDocument | None = Field(description="null without a linearisation")
    phase_margin: MarginDocument | None
    scenarios: dict[str, ScenarioDocument]


class ChallengeDocument(_Document):
    """Laws of friction compensation, ranked; ratios are to the law `off`, and less is better."""

    challenge: int = Field(description="Version of the challenge")
    digest: str = Field(description="SHA-256 of its definition")
    seed: int = Field(description="Of the drawn motors")
    own_seed: bool = Field(description="Whether the seed is another one than the challenge's")
    motors: int = Field(description="Motors drawn for a scenario")
    version: str = Field(description="Of the program")
    model: str = Field(description="Hash of the model's sources")
    titles: dict[str, str] = Field(description="Of the scenarios")
    laws: list[LawDocument] = Field(description="The best first")


HEADS = ("", "law", "score", "error", "motors", "effort", "gain", "phase", "verdict")
UNITS = ("", "", "", "", "", "", "dB", "deg", "")


def cells(law: LawDocument) -> tuple[str, ...]:
    """Return the row of a law, below `HEADS`."""
    numbers = (_ratio(each) for each in (law.score, law.error, law.motors, law.effort))
    gain, phase = gain_shown(law.gain_margin), phase_shown(law.phase_margin)
    return str(law.rank), law.label, *numbers, gain, phase, "; ".join([law.verdict, *law.reasons])


def gain_shown(margin: MarginDocument | None) -> str:
    """Return a gain margin in dB."""
    return _shown(margin, lambda factor: 20.0 * math.log10(factor))


def phase_shown(margin: MarginDocument | None) -> str:
    """Return a phase margin in degrees."""
    return _shown(margin, math.degrees)


def _shown(margin: MarginDocument | None, convert: Callable[[float], float]) -> str:
    return "-" if margin is None or margin.value is None else f"{convert(margin.value):.1f}"


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def report(document: ChallengeDocument) -> str:
    """Return the table of the laws, and where those that were named are in it."""
    seed = f", seed {document.seed}" if document.own_seed else ""
    lines = [
        f"challenge {document.challenge}: {len(document.titles)} scenarios, "
        f"{document.motors} motors{seed}",
        table(HEADS, [cells(law) for law in document.laws], right=range(2, 8), units=UNITS),
        "Ratios to the law off: less is better. docs/challenge.md defines them.",
    ]
    lines += [place_of(law, document) for law in document.laws if law.entered]
    return "\n".join(lines)


def place_of(law: LawDocument, document: ChallengeDocument) -> str:
    """Return in a sentence where a law is."""
    return f"{law.label}: rank {law.rank} of {len(document.laws)}"
