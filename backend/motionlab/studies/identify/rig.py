"""The simulated motor of an experiment under one of its controllers, without compensation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from motionlab.analysis.result_document import ResultDocument
from motionlab.config.controller import (
    AxisModelConfig,
    CompensationConfig,
    ControllerConfig,
    DisturbanceObserverConfig,
    GainsConfig,
)
from motionlab.config.load import load_scenario
from motionlab.config.scenario import LoadConfig, Scenario, VariantConfig
from motionlab.errors import ConfigError, ExperimentFailed, FieldError
from motionlab.kernel.build import AXES
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.studies.identify.documents import IdentifyRequest
from motionlab.telemetry.recording import VariantRecord

Step = Literal["sliding", "presliding"]
_ONLY = "A"


@dataclass(frozen=True)
class Rig:
    """Motor and controller of an experiment."""

    scenario: Scenario
    variant: str
    apply_to: str

    @classmethod
    def of(cls, request: IdentifyRequest, scenario: Scenario) -> Rig:
        """Return the rig of a request.

        Raises
        ------
        ConfigError
            If the scenario has no such variant.
        """
        names = list(scenario.variants)
        variant = request.variant or names[0]
        apply_to = request.apply_to or (names[1] if len(names) > 1 else names[0])
        unknown = [
            FieldError(
                loc=field,
                message="is no variant of the scenario",
                value=name,
                range="one of " + ", ".join(names),
            )
            for field, name in (("variant", variant), ("apply_to", apply_to))
            if name not in names
        ]
        if unknown:
            raise ConfigError(*unknown)
        load = scenario.load
        steady = scenario.model_copy(
            update={
                "load": LoadConfig(x=load.x, y=load.y, noise=load.noise),
                "schedule": (),
                "window": None,
            }
        )
        return cls(steady, variant, apply_to)

    @property
    def controller(self) -> ControllerConfig:
        """The controller that drives the motor, as the scenario has it."""
        return self.scenario.variants[self.variant].controller

    def model(self, axis: str) -> AxisModelConfig:
        """Return that controller's model of an axis."""
        return getattr(self.controller.model, axis)

    def identified_model(self, axis: str) -> AxisModelConfig:
        """Return the old model of an axis, of the variant whose friction is identified."""
        return getattr(self.scenario.variants[self.apply_to].controller.model, axis)

    def uncompensated(self) -> Scenario:
        """Return the scenario under position control alone, eq. (15)."""
        return self._under(
            self.controller.model_copy(
                update={
                    "compensation": CompensationConfig(law="off"),
                    "feedforward": False,
                    "disturbance_observer": DisturbanceObserverConfig(),
                }
            )
        )

    def open_loop(self, axis: str) -> Scenario:
        """Return the scenario with one axis without feedback.

        Its gains are zero and the feedforward is on: the force command is the model's mass times
        the reference's acceleration, through force sharing, limits and currents as any other.
        """
        controller = self.uncompensated().variants[_ONLY].controller
        return self._under(
            controller.model_copy(update={axis: GainsConfig(k_p=0.0, k_d=0.0), "feedforward": True})
        )

    def seed(self, axis: str, step: Step, index: int) -> int:
        """Return a seed of its own for one run of the experiment."""
        key = (AXES.index(axis), ("sliding", "presliding").index(step), index)
        sequence = np.random.SeedSequence(self.scenario.seed, spawn_key=key)
        return int(sequence.generate_state(1)[0])

    def _under(self, controller: ControllerConfig) -> Scenario:
        variant = VariantConfig(label="identification", controller=controller)
        return self.scenario.model_copy(update={"variants": {_ONLY: variant}})


def record(prepared: Prepared, progress: Callable[[int], None] | None = None) -> VariantRecord:
    """Run one motion of the experiment; `progress` takes the ticks done since its last call.

    Raises
    ------
    ExperimentFailed
        If the axis diverged.
    """
    result = run(prepared, progress).variants[_ONLY]
    if result.diverged is not None:
        raise ExperimentFailed(
            f"identification: the motor diverged at t = {result.diverged.time:.4f} s of "
            f"one motion: {result.diverged.channel}"
        )
    return result


def compare_models(
    rig: Rig,
    source: str | Path | dict[str, Any],
    changes: Mapping[str, Any],
    identified: Mapping[str, float],
) -> ResultDocument:
    """Return the result document of the circle with the old model (A) and the new one (B)."""
    new = load_scenario(source, {**changes, **identified})
    scenario = rig.scenario.model_copy(
        update={
            "name": "circle",
            "trajectory": load_scenario("circle").trajectory,
            "learnt": None,
            "variants": {
                "A": VariantConfig(
                    label="friction model as it was",
                    controller=rig.scenario.variants[rig.apply_to].controller,
                ),
                "B": VariantConfig(
                    label="friction model identified",
                    controller=new.variants[rig.apply_to].controller,
                ),
            },
        }
    )
    prepared = prepare(scenario)
    return ResultDocument.model_validate(document(prepared, run(prepared)))
