"""The sliding force of a guide and its parameters, which the effects of friction share.

``s(v, p, N) = (F_c + (F_s - F_c) exp(-(v/v_s)^2) + mu N) (1 + A sin(2 pi p/L))``
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from motionlab.effects.effect import OURS, MidStep, Parameter
from motionlab.lanes import Lanes, compiled, select
from motionlab.lanes.functions import decay, sign, sine_cosine
from motionlab.plant.friction import LuGre, steady_friction, stribeck

OF_GUIDE = "of plant.x.friction, or y, if left out"


def _of_guide(name: str, what: str, unit: str, ge: float, le: float, **more: Any) -> Parameter:
    return Parameter(name, f"{what}; that {OF_GUIDE}", unit=unit, ge=ge, le=le, **more)


STIFFNESS = _of_guide(
    "sigma_0", "Stiffness before sliding", "N/m", 1, 1e8, label="stiffness \u03c3_0", shown="N/mm"
)
BRISTLE_DAMPING = _of_guide(
    "sigma_1", "Bristle damping", "N s/m", 0, 1e6, label="damping \u03c3_1", shown="N s/mm"
)
VISCOUS = _of_guide("sigma_2", "Viscous friction", "N s/m", 0, 1e4, label="viscous \u03c3_2")
COULOMB = _of_guide("F_c", "Coulomb friction", "N", 1e-6, 100, label="Coulomb F_c")
STICTION = _of_guide("F_s", "Stiction", "N", 1e-6, 100, label="stiction F_s")
STRIBECK_VELOCITY = _of_guide(
    "v_s", "Stribeck velocity", "m/s", 1e-5, 10, label="speed v_s", shown="mm/s"
)
DEPENDENCES = (
    Parameter(
        "mu",
        "Friction per normal force of the motor, added to F_c and F_s",
        unit="1",
        default=0.0,
        ge=0,
        le=1,
        usual=(0.001, 0.1),
    ),
    Parameter(
        "position_amplitude",
        "Relative change of the friction along the stroke, A in 1 + A sin(2 pi p/L)",
        unit="1",
        default=0.0,
        ge=0,
        le=0.9,
        usual=(0.01, 0.5),
    ),
    Parameter(
        "position_period",
        "Period L of that change",
        unit="m",
        shown="mm",
        default=0.06,
        ge=1e-4,
        le=1,
        source=f"{OURS}: a third of the stroke",
    ),
)
STRIBECK_CURVE = (COULOMB, STICTION, STRIBECK_VELOCITY)


@compiled
def dependent(par: Any, seen: MidStep, level: Lanes) -> Lanes:
    """Return a sliding force, N, with its dependence on normal force and position."""
    along, _ = sine_cosine(seen.position / par.position_period)
    return (level + par.mu * seen.normal_force) * (1.0 + par.position_amplitude * along)


@compiled
def curve(par: Any, seen: MidStep) -> Lanes:
    """Return the Stribeck curve ``s(v)``, N; `par` has its parameters."""
    return stribeck(par, seen.velocity)


@compiled
def sliding_force(par: Any, seen: MidStep) -> Lanes:
    """Return ``s(v, p, N)``, N, a magnitude; `par` has the Stribeck curve and `DEPENDENCES`."""
    return dependent(par, seen, curve(par, seen))


@compiled
def bristle_step(sigma_0: Lanes, level: Lanes, z: Lanes, seen: MidStep) -> tuple[Lanes, Lanes, Any]:
    """Return the bristle state, m, at a step's end, its mean over the step, and what is left of it.

    ``dz/dt = v - sigma_0 abs(v)/s z`` relaxes exactly at constant velocity; see
    `motionlab.plant.mechanics.advance`.
    """
    v = seen.velocity
    x = sigma_0 * abs(v) * seen.h / level
    e, phi_1 = decay(x, 1.0 / select(x > 0.0, x, 1.0))
    # Without g, which at rest has no sign: (1 - e) g = h v phi_1.
    end = z * e + seen.h * v * phi_1
    g = sign(v) * level / sigma_0
    mean = select(x > 0.0, g + (z - g) * phi_1, z)
    return end, mean, e


def lane_of(record: Any) -> Callable[[Mapping[str, Any], LuGre], Any]:
    """Return `Effect.lane` of parameters of which those left out are the guide's."""

    def lane(values: Mapping[str, Any], friction: LuGre) -> Any:
        numbers = {name: values[name] for name in record._fields}
        return record(
            **{k: getattr(friction, k) if value is None else value for k, value in numbers.items()}
        )

    return lane


def steady_level(par: Any, v: Any) -> Any:
    """Return `Effect.level`: the steady force at velocities, N, at its largest along the stroke.

    What grows with the normal force is left out: a motion's check knows no currents.
    """
    most = 1.0 + par.position_amplitude
    return steady_friction(v, most * par.F_c, most * par.F_s, par.v_s, par.sigma_2)


def stiction_below(par: Any) -> str | None:
    """Return `Effect.refuse`: why a stiction below Coulomb friction is refused."""
    if par.F_s >= par.F_c:
        return None
    return f"F_s = {par.F_s:g} N is below F_c = {par.F_c:g} N"
