"""The linearised loop of an axis, with its margins, and as systems of python-control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError, naming_extras
from motionlab.executors.progress import first_use
from motionlab.loop.family import stability_limits
from motionlab.loop.linearise import SLIDING, StateSpace
from motionlab.loop.linearise import linearise as linearised
from motionlab.loop.margins import Margins, margins
from motionlab.scripting.arguments import Changes, Source, changes_of, check_number, readable
from motionlab.timing import CONTROL_PERIOD

if TYPE_CHECKING:
    import control


_FASTEST = 10.0  # m/s


class ControlLoop(NamedTuple):
    """A loop as discrete systems of python-control, 0.5 ms apart; delays are states.

    Attributes
    ----------
    plant : control.StateSpace
        Force command, N, to position, m.
    controller : control.StateSpace
        Position, m, to the opposite of the force command, N.
    open_loop : control.StateSpace
        ``L = C P``; closed by negative feedback.
    disturbance : control.StateSpace
        Force added to the command, N, to position, m: ``P/(1 + C P)``.
    """

    plant: control.StateSpace
    controller: control.StateSpace
    open_loop: control.StateSpace
    disturbance: control.StateSpace


@dataclass(frozen=True)
class LinearLoop:
    """The sampled loop of one axis about sliding at one velocity (docs/loop.md).

    Attributes
    ----------
    plant, controller : StateSpace
        Matrices ``A, B, C, D`` of ``x+ = A x + B u, y = C x + D u`` every 0.5 ms: force command, N,
        to position, m, and position to the opposite of the force command.
    velocity : float
        Sliding velocity, m/s; 0 is stuck.
    stable : bool
        Whether every pole of the closed loop lies inside the unit circle.
    margins : Margins
        Crossover and bandwidth, Hz; phase margin, rad; gain margin; Ms.
    k_p_limit, k_d_limit : float or None
        Nearest gains at which stability changes at that velocity, N/m and N s/m.
    stable_at_rest : bool
        As `stable`, of the axis that is stuck.
    margins_at_rest : Margins
        As `margins`, of the axis that is stuck: the bristle is a spring.
    """

    plant: StateSpace
    controller: StateSpace
    velocity: float
    stable: bool
    margins: Margins
    k_p_limit: float | None
    k_d_limit: float | None
    stable_at_rest: bool
    margins_at_rest: Margins

    @naming_extras("to_control")
    def to_control(self) -> ControlLoop:
        """Return the loop as systems of python-control.

        Raises
        ------
        NotInstalled
            If python-control is not installed.
        """
        import control

        plant = _system(self.plant, "plant", "force", "position")
        controller = _system(self.controller, "controller", "position", "force")
        disturbance: Any = control.feedback(plant, controller)
        return ControlLoop(plant, controller, control.series(plant, controller), disturbance)


def _system(system: StateSpace, name: str, enters: str, leaves: str) -> Any:
    import control

    B, C = system.B[:, None], system.C[None, :]
    return control.ss(
        system.A, B, C, system.D, CONTROL_PERIOD, name=name, inputs=enters, outputs=leaves
    )


@first_use()
def linearise(
    scenario: Source = "circle",
    variant: str | None = None,
    axis: Literal["x", "y"] = "x",
    set: Changes = None,
    *,
    velocity: float | None = None,
) -> LinearLoop:
    """Linearise the loop of one axis about sliding at one velocity.

    Parameters
    ----------
    scenario, set
        As of `motionlab.run`.
    variant : str, optional
        Which controller; the last one when left out.
    axis : str
        ``x`` or ``y``.
    velocity : float, optional
        Sliding velocity, m/s, 0 is stuck; four Stribeck velocities when left out, where friction
        no longer falls with velocity.

    Raises
    ------
    ConfigError
        For a law that has no linearisation, or a variant or axis that is not there.
    """
    resolved: Scenario = load_scenario(readable(scenario), changes_of(set))
    name = list(resolved.variants)[-1] if variant is None else variant
    _refuse_others("variant", name, list(resolved.variants))
    _refuse_others("axis", axis, ["x", "y"])
    if velocity is not None:
        check_number("velocity", velocity, unit="m/s", minimum=0.0, maximum=_FASTEST)
    v_s = getattr(resolved.plant, axis).friction.v_s
    v = SLIDING * v_s if velocity is None else velocity
    loop, rest = linearised(resolved, name, axis, v=v), linearised(resolved, name, axis, v=0.0)
    limits = stability_limits(resolved, name, axis, v / v_s)
    return LinearLoop(
        plant=loop.plant,
        controller=loop.controller,
        velocity=v,
        stable=loop.stable,
        margins=margins(loop.open),
        k_p_limit=limits["k_p"],
        k_d_limit=limits["k_d"],
        stable_at_rest=rest.stable,
        margins_at_rest=margins(rest.open),
    )


def _refuse_others(loc: str, value: str, known: list[str]) -> None:
    if value not in known:
        raise ConfigError(FieldError(loc, "is not there", value, f"one of {', '.join(known)}"))
