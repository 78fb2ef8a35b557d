"""Cost of the motion of a recording, each variant beside the first; docs/views.md."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.analysis import cost as numbers
from motionlab.analysis.cost import HELD, LINEAR, Within, settling
from motionlab.analysis.views.recorded import Recorded
from motionlab.config.planar import AXES
from motionlab.config.quantity import si
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]

_PHASES = ("a", "b", "c")
_NOTHING = 1e-12
"""Below this a figure of the first variant is nothing that another can be related to."""

_RATIO = Field(description="Over that of the first variant; null where that is nothing")


class EnergyBalance(BaseModel):
    """Mechanical energy, J: thrust = friction + load + kinetic + residual."""

    thrust: float = Field(description="Work of the thrust, J")
    friction: float = Field(description="Work against friction, J")
    load: float = Field(description="Work against load and pushes, J")
    kinetic: float = Field(description="Kinetic energy gained, J")
    residual: float = Field(description="What sums over samples leave, J")


class PhaseCost(BaseModel):
    """One phase."""

    copper: float = Field(description="Integral of the squared current: J for each ohm, A^2 s")
    peak: float = Field(description="Largest magnitude of the current, A")
    rms: float = Field(description="Of the current, A")


class CostRatios(BaseModel):
    """Figures over those of the first variant."""

    copper: float | None = _RATIO
    current_peak: float | None = _RATIO
    current_rms: float | None = _RATIO
    thrust_work: float | None = _RATIO
    friction_work: float | None = _RATIO
    force_peak: float | None = _RATIO
    force_rms: float | None = _RATIO
    force_rate: float | None = _RATIO
    saturated: float | None = _RATIO


class AxisCost(BaseModel):
    """One axis of one variant; null is what cannot be computed."""

    phases: dict[str, PhaseCost | None] = Field(description="a, b and c")
    worst_phase: str | None = Field(description="Of the largest RMS current")
    copper: float | None = Field(description="Sum of the phases: J for each ohm, A^2 s")
    current_peak: float | None = Field(description="Of all phases, A")
    current_rms: float | None = Field(description="Of the worst phase, A")
    thrust_work: float | None = Field(description="J")
    friction_work: float | None = Field(description="J")
    balance: EnergyBalance | None
    force_peak: float | None = Field(description="Largest thrust, N")
    force_rms: float | None = Field(description="Of the thrust, N")
    force_rate: float | None = Field(description="RMS rate of the force command, N/s")
    saturated: float | None = si(
        "Share of samples with a force or current limited",
        "1",
        "%",
    )
    missing: list[str] = Field(description="Channels that are not in the recording or have gaps")
    ratios: CostRatios | None = Field(description="null for the first variant")


class Cost(BaseModel):
    """Cost of each variant over a stretch."""

    start: float = Field(description="s")
    end: float = Field(description="s")
    variants: dict[str, dict[str, AxisCost]] = Field(description="By axis")
    note: str = Field(description="What is not known of the motor; empty where nothing is")


class _Motor(NamedTuple):
    """Constants of one axis that its sums need beside channels."""

    mass: float | None
    within: Within


def cost(recorded: Recorded) -> Cost:
    """Return the cost of the motion of a recording.

    Raises
    ------
    ConfigError
        If it has less than two samples, or none of the channels of any variant.
    """
    if recorded.stop - recorded.first < 2:
        raise ConfigError(FieldError("end", "less than two samples", recorded.end, unit="s"))
    motors = {axis: _motor(recorded, axis) for axis in AXES}
    variants: dict[str, dict[str, AxisCost]] = {}
    for name in recorded.variants:
        firsts = next(iter(variants.values()), {})
        variants[name] = {
            axis: _axis(recorded, name, axis, motors[axis], firsts.get(axis)) for axis in AXES
        }
    note = ""
    if isinstance(recorded.scenario, str):
        note = (
            f"The motor is not known ({recorded.scenario}): without its mass there is no energy "
            "balance, and between samples quantities go in straight lines"
        )
    return Cost(start=recorded.start, end=recorded.end, variants=variants, note=note)


def _motor(recorded: Recorded, axis: str) -> _Motor:
    scenario = recorded.scenario
    if not isinstance(scenario, Scenario):
        return _Motor(None, LINEAR)
    part = getattr(scenario.plant, axis)
    if scenario.plant.force == "ideal":
        return _Motor(part.mass, HELD)
    bandwidth = part.amplifiers.bandwidth
    tau = 0.0 if bandwidth is None else 1 / (2 * math.pi * bandwidth)
    return _Motor(part.mass, settling(tau, recorded.period))


def _axis(
    recorded: Recorded, name: str, axis: str, motor: _Motor, first: AxisCost | None
) -> AxisCost:
    missing: list[str] = []

    def known(channel: str, *, shared: bool = False) -> Array | None:
        column = f"{axis}.{channel}" if shared else f"{name}.{axis}.{channel}"
        values = recorded.whole([column])
        if values is None:
            missing.append(column)
        return None if values is None else values[0]

    period = recorded.period
    # An ideal force needs no currents; those shared for it settle as any do.
    phases = {phase: _phase(known(f"current_{phase}"), motor, period) for phase in _PHASES}
    there = {phase: one for phase, one in phases.items() if one is not None}
    all_there = len(there) == len(_PHASES)
    worst = max(there, key=lambda phase: there[phase].rms) if all_there else None
    thrust, velocity, friction = known("thrust"), known("velocity"), known("friction")
    command = known("force_command")
    limits = [known(f"{what}_saturated") for what in ("force", "current")]
    cost = AxisCost(
        phases=dict(phases),
        worst_phase=worst,
        copper=sum(one.copper for one in there.values()) if all_there else None,
        current_peak=max(one.peak for one in there.values()) if all_there else None,
        current_rms=None if worst is None else there[worst].rms,
        thrust_work=_work(thrust, velocity, period, motor.within),
        friction_work=_work(friction, velocity, period, LINEAR),
        balance=None,
        force_peak=None if thrust is None else float(np.abs(thrust).max()),
        force_rms=None if thrust is None else numbers.rms(thrust),
        force_rate=None if command is None else numbers.rate(command, period),
        saturated=_share(limits),
        missing=missing,
        ratios=None,
    )
    load = known("load_force", shared=True)
    if not (
        motor.mass is None or thrust is None or friction is None or load is None or velocity is None
    ):
        moved = numbers.Moved(thrust, friction, load, velocity)
        balanced = numbers.balance(moved, mass=motor.mass, period=period, within=motor.within)
        cost.balance = EnergyBalance(**asdict(balanced))
    if first is not None:
        cost.ratios = _ratios(cost, first)
    return cost


def _phase(current: Array | None, motor: _Motor, period: float) -> PhaseCost | None:
    if current is None:
        return None
    copper = numbers.square_integral(current, period, motor.within)
    return PhaseCost(
        copper=copper,
        peak=float(np.abs(current).max()),
        rms=math.sqrt(copper / ((len(current) - 1) * period)),
    )


def _work(
    force: Array | None, velocity: Array | None, period: float, within: Within
) -> float | None:
    if force is None or velocity is None:
        return None
    return numbers.work(force, velocity, period, within)


def _share(limits: list[Array | None]) -> float | None:
    known = [one > 0.0 for one in limits if one is not None]
    return float(np.mean(known[0] | known[1])) if len(known) == len(limits) else None


def _ratios(own: AxisCost, first: AxisCost) -> CostRatios:
    ratios: dict[str, float | None] = {}
    for name in CostRatios.model_fields:
        value, of = getattr(own, name), getattr(first, name)
        ratios[name] = None if value is None or not of or abs(of) < _NOTHING else value / of
    return CostRatios(**ratios)
