"""Force-sharing functions compared over a pole pitch: ripple, copper loss, peak current."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from motionlab.config.controller import SharingConfig, SharingLaw
from motionlab.config.force_map import AnyForceMapConfig, ForceMapConfig, MapName, TableMapConfig
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.config.quantity import quantity, si
from motionlab.declarations import OURS
from motionlab.errors import ConfigError, FieldError
from motionlab.force_sharing.ripple import OverPitch, Ripple, ripple, share_over_pitch
from motionlab.kernel.force_maps import force_model, map_lanes
from motionlab.lanes.bank import TABLES
from motionlab.motor_design.kept_maps import named_map
from motionlab.studies.sharing.map_fit import fit_analytic

Array = NDArray[np.float64]


def _is_name(value: Any) -> str:
    return "name" if isinstance(value, str) else "map"


MapChoice = Annotated[
    Annotated[MapName, Tag("name")] | Annotated[AnyForceMapConfig, Tag("map")],
    Discriminator(_is_name),
]
"""A force map, or the name of a table or of a shipped motor, for its axis x."""


class SharingRequest(SharingConfig):
    """A force command, the controller's map and law, and the plant's map."""

    controller: MapChoice = Field(
        default="nominal",
        description="The controller's map: a map, or the name of a table or of a shipped motor",
    )
    plant: MapChoice | None = Field(
        default=None, description="The plant's map; left out: the controller's"
    )
    force: float = quantity(
        "Commanded force", label="force", unit="N", source=OURS, default=20.0, ge=-1000, le=1000
    )
    current_limit: float = quantity(
        "Largest current command", unit="A", source=OURS, default=10.0, gt=0, le=100
    )
    resistance: float | None = quantity(
        "Resistance of one phase, for the loss in W; the paper prints none",
        unit="Ohm",
        source=OURS,
        default=None,
        gt=0,
        le=1000,
    )
    points: int = quantity(
        "Positions over the pole pitch", unit="1", source=OURS, default=360, ge=12, le=3600
    )


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class UsedMap(_Document):
    """A map that was used."""

    name: str | None = Field(description="As it was asked for; null for numbers")
    kind: Literal["analytic", "table"]
    tau: float = Field(description="Pole pitch, m")
    digest: str | None = Field(description="Hash of a table's numbers")


class RippleOfThrust(_Document):
    """Ripple of a thrust over the pole pitch."""

    mean: float = Field(description="N")
    peak_to_peak: float = Field(description="N")
    rms: float = Field(description="Of what it differs from its mean, N")
    relative: float | None = si("Peak to peak over the mean; null without a mean", "1", "%")


class CopperLoss(_Document):
    """Copper loss of the three phases, averaged over the pole pitch."""

    squared_current: float = Field(description="Sum of the squared currents, A^2")
    relative: float | None = Field(description="Over that of force-per-ampere; null without any")
    power: float | None = Field(description="W; null without a resistance")


class NormalForce(_Document):
    """Normal force of the three phases over the pole pitch, on the plant's map."""

    mean: float = Field(description="N")
    largest: float = Field(description="N")


class SharingCurves(_Document):
    """Forces and currents at each position."""

    position: list[float] = Field(description="Over one pole pitch of the controller's map, m")
    current: list[list[float]] = Field(description="Of phases a, b, c, A")
    phase_thrust: list[list[float]] = Field(description="Of phases a, b, c on the plant's map, N")
    thrust: list[float] = Field(description="On the plant's map, N")
    believed: list[float] = Field(description="On the controller's map, N")
    normal_force: list[float] = Field(description="On the plant's map, N")
    reachable: list[float] = Field(description="Largest command that is carried out, N")
    squared_current: list[float] = Field(description="Sum of the squared currents, A^2")


class SharingDocument(_Document):
    """Response to a force command over one pole pitch."""

    foot: ClassVar[str] = (
        "Thrust is on the plant's map, believed on the controller's. Loss is the sum of the "
        "squared currents, mean over the pitch; relative: to that of force-per-ampere.\n"
        "Reachable most: the largest thrust at the best place of the pitch."
    )

    law: SharingLaw
    force: float = Field(description="Commanded, N")
    current_limit: float = Field(description="A")
    controller: UsedMap
    plant: UsedMap
    linear_up_to: float = Field(description="Command that is carried out at every position, N")
    reachable_most: float = Field(description="Largest command carried out at some position, N")
    thrust: RippleOfThrust = Field(description="On the plant's map")
    believed: RippleOfThrust = Field(description="On the controller's map")
    loss: CopperLoss
    normal_force: NormalForce
    rms_current: float = Field(description="Of one phase over the pitch, A")
    max_current: float = Field(description="A")
    steepest_current: float = Field(description="Largest change of a current over position, A/m")
    curves: SharingCurves


class FitDocument(_Document):
    """The analytic map fitted to a table: F_pk, I_knee, h_2 and h_3 are fits."""

    name: str
    digest: str = Field(description="Hash of the table's numbers")
    force_map: ForceMapConfig = Field(description="To be set as force_map of a controller's model")
    fitted: list[str] = Field(description="Which of its fields are fits")
    relative_rms: float = si(
        "Residual of thrust over the largest at the same current, 1; made least", "1", "%"
    )
    rms: float = Field(description="Residual of thrust over positions and currents, N")
    worst: float = Field(description="Largest residual, N")
    worst_position: float = Field(description="Where, from the aligned position, m")
    worst_current: float = Field(description="At which current, A")

    @property
    def foot(self) -> str:
        """The map as a scenario has it."""
        m = self.force_map
        return (
            f"As numbers for a controller's model: {{ tau = {m.tau:g}, F_pk = {m.F_pk:.5g}, "
            f"N_pk = {m.N_pk:.5g}, I_pk = {m.I_pk:g}, I_knee = {m.I_knee:.5g}, h_2 = {m.h_2:.5g}, "
            f"h_3 = {m.h_3:.5g} }}"
        )


def sharing(request: SharingRequest) -> SharingDocument:
    """Return the response to a force command over one pole pitch.

    Raises
    ------
    ConfigError
        If a map is not there or does not reach the current limit, or the pole pitches differ.
    """
    controller, used = _used(request.controller, "controller")
    plant, truth = (controller, used) if request.plant is None else _used(request.plant, "plant")
    if truth.tau != used.tau:
        raise ConfigError(
            FieldError("plant", "has another pole pitch than the controller's map", truth.tau)
        )
    for field, config in (("controller", controller), ("plant", plant)):
        if isinstance(config, TableMapConfig):
            i_max = named_map(config.name).i_max
            if request.current_limit > i_max:
                raise ConfigError(
                    FieldError(
                        "current_limit",
                        f"is more than the {field}'s map reaches",
                        request.current_limit,
                        unit="A",
                        bounds={"maximum": i_max},
                    )
                )
    curves = _over_pitch(request, controller, plant, request.law)
    least = curves
    if request.law != "force-per-ampere":
        least = _over_pitch(request, controller, plant, "force-per-ampere")
    loss, least_loss = float(curves.loss.mean()), float(least.loss.mean())
    step = curves.position[1] - curves.position[0]
    slope = np.abs(np.diff(curves.current, axis=1, append=curves.current[:, :1])) / step
    return SharingDocument(
        law=request.law,
        force=request.force,
        current_limit=request.current_limit,
        controller=used,
        plant=truth,
        linear_up_to=float(curves.reachable.min()),
        reachable_most=float(curves.reachable.max()),
        thrust=_ripple(ripple(curves.thrust)),
        believed=_ripple(ripple(curves.believed)),
        loss=CopperLoss(
            squared_current=loss,
            relative=loss / least_loss if least_loss > 0.0 else None,
            power=None if request.resistance is None else request.resistance * loss,
        ),
        normal_force=NormalForce(
            mean=float(curves.normal_force.mean()), largest=float(curves.normal_force.max())
        ),
        rms_current=float(np.sqrt(loss / 3.0)),
        max_current=float(curves.current.max()),
        steepest_current=float(slope.max()),
        curves=SharingCurves(
            position=curves.position.tolist(),
            current=curves.current.tolist(),
            phase_thrust=curves.phase_thrust.tolist(),
            thrust=curves.thrust.tolist(),
            believed=curves.believed.tolist(),
            normal_force=curves.normal_force.tolist(),
            reachable=curves.reachable.tolist(),
            squared_current=curves.loss.tolist(),
        ),
    )


def fit(name: str) -> FitDocument:
    """Return the analytic map fitted to a table.

    Raises
    ------
    ConfigError
        If no map of that name is there, or it cannot be read.
    """
    table = named_map(name, "map")
    fitted = fit_analytic(table)
    return FitDocument(
        name=name,
        digest=table.digest,
        force_map=ForceMapConfig(**fitted.force_map._asdict()),
        fitted=["F_pk", "I_knee", "h_2", "h_3"],
        relative_rms=fitted.relative_rms,
        rms=fitted.rms,
        worst=fitted.worst,
        worst_position=fitted.position,
        worst_current=fitted.current,
    )


def _used(choice: str | AnyForceMapConfig, loc: str) -> tuple[AnyForceMapConfig, UsedMap]:
    """Return a map and its description."""
    name = choice if isinstance(choice, str) else None
    config = choice
    if isinstance(config, str):
        if config in names("motors"):
            config = load_scenario("circle", {"plant": config}).plant.x.force_map
        else:
            config = TableMapConfig(name=config)
    if isinstance(config, ForceMapConfig):
        return config, UsedMap(name=name, kind="analytic", tau=config.tau, digest=None)
    table = named_map(config.name, loc)
    named = UsedMap(name=name or config.name, kind="table", tau=table.tau, digest=table.digest)
    return config, named


@TABLES.lease()
def _over_pitch(
    request: SharingRequest,
    controller: AnyForceMapConfig,
    plant: AnyForceMapConfig,
    law: SharingLaw,
) -> OverPitch:
    config = SharingConfig(law=law, **request.parameters())
    return share_over_pitch(
        force_model(controller, config, request.current_limit),
        map_lanes(plant),
        force=request.force,
        points=request.points,
    )


def _ripple(ripple: Ripple) -> RippleOfThrust:
    return RippleOfThrust(**ripple._asdict(), relative=ripple.relative)
