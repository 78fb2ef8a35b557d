"""A scenario: motor, controllers, trajectory, load, schedule and seed; one TOML file."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from motionlab.config.controller import ControllerConfig
from motionlab.config.learnt_force import LearntForce
from motionlab.config.plant import OURS, PlantConfig
from motionlab.config.quantity import Config, Text, quantity
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.timing import to_ticks

VariantName = Annotated[str, Field(pattern="^[A-Z]$")]


class VariantConfig(Config):
    """One controller of a comparison."""

    label: str = Field(default="", description="Name for people", max_length=80)
    controller: ControllerConfig


class ForceStepConfig(Config):
    """A change of the external load force."""

    time: float = quantity("When the force changes", unit="s", source=OURS, ge=0, le=3600)
    x: float = quantity("Force added on x", unit="N", source=OURS, default=0.0, ge=-100, le=100)
    y: float = quantity("Force added on y", unit="N", source=OURS, default=0.0, ge=-100, le=100)


class LoadConfig(Config):
    """External load force f_d of eq. (16); positive forces push towards negative positions."""

    x: float = quantity(
        "Constant force on x", label="load x", unit="N", source=OURS, default=0.0, ge=-100, le=100
    )
    y: float = quantity(
        "Constant force on y", label="load y", unit="N", source=OURS, default=0.0, ge=-100, le=100
    )
    noise: float = quantity(
        "White force noise on each axis, held over each control period, rms",
        label="load noise",
        unit="N",
        source=OURS,
        default=0.0,
        ge=0,
        le=100,
    )
    steps: Annotated[tuple[ForceStepConfig, ...], Field(strict=False, max_length=1000)] = Field(
        default=(), description="Force steps"
    )


class EventConfig(Config):
    """A change of parameters at a tick: of the plant, the load, or a variant's controller."""

    time: float = quantity("When the change takes effect", unit="s", source=OURS, gt=0, le=3600)
    set: dict[str, Any] = Field(description="Dotted path to value, as with --set", min_length=1)


class WindowConfig(Config):
    """The part of a run that metrics are taken over."""

    start: float = quantity("Start", unit="s", source=OURS, ge=0, le=3600)
    end: float = quantity("End", unit="s", source=OURS, gt=0, le=3600)

    @model_validator(mode="after")
    def _has_length(self) -> Self:
        if to_ticks(self.end) <= to_ticks(self.start):
            raise ValueError(
                f"end = {self.end:g} s is not a control period after start = {self.start:g} s"
            )
        return self


class Scenario(Config):
    """Complete input of a run: equal scenarios give bit-identical results."""

    name: str = Field(default="custom", pattern="^[a-z0-9-]{1,64}$", description="Short name")
    title: str = Field(default="", description="One line for people", max_length=120)
    description: Text = Field(
        default="", description="What it shows and whose choice its numbers are"
    )
    seed: int = quantity(
        "Seed of every noise source", unit="1", source=OURS, default=2019, ge=0, le=2**53 - 1
    )
    plant: PlantConfig = Field(title="motor")
    variants: dict[VariantName, VariantConfig] = Field(
        description="Controllers by letter; B is compared with A", min_length=1, max_length=26
    )
    trajectory: TrajectoryConfig
    learnt: LearntForce | None = Field(
        default=None, title="learnt force", description="Force that was learnt of the motion"
    )
    load: LoadConfig = LoadConfig()
    schedule: Annotated[tuple[EventConfig, ...], Field(strict=False, max_length=100)] = Field(
        default=(), description="Changes during the run"
    )
    window: WindowConfig | None = Field(
        default=None, description="Metrics window; left out: what suits the trajectory"
    )
    settling_band: float = quantity(
        "Following error below which a move counts as settled",
        shown="µm",
        unit="m",
        source=OURS,
        default=2e-6,
        gt=0,
        le=1e-3,
    )
    divergence_error: float = quantity(
        "Following error beyond which a variant has diverged",
        shown="mm",
        unit="m",
        source=OURS,
        default=0.02,
        gt=0,
        le=1,
    )
    thrust_reserve: float = quantity(
        "Share of the force sharing's linear range that a motion leaves to feedback to be feasible",
        label="thrust reserve",
        shown="%",
        unit="1",
        source=OURS,
        default=0.12,
        ge=0,
        le=0.9,
    )
