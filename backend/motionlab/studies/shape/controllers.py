"""Controllers with other gains, bandwidth and filters, as their responses."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ControllerConfig, FilterConfig, NotchConfig
from motionlab.config.scenario import Scenario
from motionlab.loop.linearise import linearise

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

FILTERS = ("filter_1", "filter_2", "filter_3")
FREQUENCY_MAX = 900.0
Kind = Literal["notch", "low-pass", "lead"]


@dataclass(frozen=True)
class Shape:
    """What is searched of a controller.

    Attributes
    ----------
    k_p, k_d : float
        N/m and N s/m.
    bandwidth : float
        Of the disturbance observer, Hz; 0 where it does not act.
    filters : tuple of AddedFilter
        In the order in which they were added.
    """

    k_p: float
    k_d: float
    bandwidth: float
    filters: tuple[AddedFilter, ...] = ()

    @property
    def numbers(self) -> Array:
        """Logarithms of all that is searched."""
        observer = [self.bandwidth] if self.bandwidth > 0.0 else []
        own = [value for each in self.filters for value in each.numbers]
        return np.log([self.k_p, self.k_d, *observer, *own])

    def with_numbers(self, logarithms: Array) -> Shape:
        """Return the shape of other logarithms."""
        k_p, k_d, *rest = np.exp(logarithms).tolist()
        bandwidth = rest.pop(0) if self.bandwidth > 0.0 else 0.0
        filters = []
        for each in self.filters:
            count = len(each.numbers)
            filters.append(replace(each, numbers=tuple(rest[:count])))
            rest = rest[count:]
        return Shape(k_p, k_d, bandwidth, tuple(filters))


@dataclass(frozen=True)
class AddedFilter:
    """A filter that is added.

    Attributes
    ----------
    kind : str
        ``notch`` of frequency, damping and gain; ``low-pass`` of its frequency; ``lead`` of middle
        and ratio of its frequencies.
    place : str
        Where it goes.
    numbers : tuple of float
        As `kind` has them.
    reason : str
        Why.
    limits : tuple of pairs
        Of each number.
    """

    kind: Kind
    place: str
    numbers: tuple[float, ...]
    reason: str = field(compare=False)
    limits: tuple[tuple[float, float], ...] = field(compare=False)

    @property
    def values(self) -> dict[str, float]:
        """Fields of its config."""
        match self.kind:
            case "notch":
                f, damping, gain = self.numbers
                if self.place == "notch":
                    return {"frequency": f, "damping": damping, "gain": gain}
                return _pairs(f, gain * damping, f, damping)
            case "low-pass":
                return _pairs(0.0, 0.7, self.numbers[0], 0.7)
            case _:
                middle, ratio = self.numbers
                root = math.sqrt(ratio)
                return _pairs(middle / root, 1.0, min(middle * root, FREQUENCY_MAX), 1.0)


def _pairs(
    zeros: float, zeros_damping: float, poles: float, poles_damping: float
) -> dict[str, float]:
    return {
        "zeros_frequency": zeros,
        "zeros_damping": zeros_damping,
        "poles_frequency": poles,
        "poles_damping": poles_damping,
    }


def present(controller: ControllerConfig, axis: str) -> Shape:
    """Return the gains in effect."""
    gains, observer = getattr(controller, axis), controller.disturbance_observer
    return Shape(gains.k_p, gains.k_d, observer.bandwidth if observer.enabled else 0.0)


def free_places(controller: ControllerConfig, axis: str) -> list[str]:
    """Return where a filter can be added: those that act are kept as they are."""
    gains = getattr(controller, axis)
    notch = ["notch"] if gains.notch.gain == 1.0 else []
    return notch + [name for name in FILTERS if getattr(gains, name).poles_frequency == 0.0]


def with_shape(controller: ControllerConfig, axis: str, shape: Shape) -> ControllerConfig:
    """Return the controller with other gains and bandwidth, and with added filters."""
    gains: dict[str, Any] = {"k_p": shape.k_p, "k_d": shape.k_d}
    for each in shape.filters:
        model = NotchConfig if each.place == "notch" else FilterConfig
        gains[each.place] = model.model_construct(None, **each.values)
    update: dict[str, Any] = {axis: getattr(controller, axis).model_copy(update=gains)}
    if shape.bandwidth > 0.0:
        observer = controller.disturbance_observer
        update["disturbance_observer"] = observer.model_copy(update={"bandwidth": shape.bandwidth})
    return controller.model_copy(update=update)


def changes_of(variant: str, axis: str, before: Shape, shape: Shape) -> dict[str, float]:
    """Return a shape as dotted paths."""
    own = f"variants.{variant}.controller"
    changes = {f"{own}.{axis}.k_p": shape.k_p, f"{own}.{axis}.k_d": shape.k_d}
    if shape.bandwidth != before.bandwidth:
        changes[f"{own}.disturbance_observer.bandwidth"] = shape.bandwidth
    for each in shape.filters:
        changes |= {f"{own}.{axis}.{each.place}.{key}": v for key, v in each.values.items()}
    return changes


@dataclass(frozen=True)
class Controllers:
    """Responses of one axis of one variant's controller at the measured frequencies.

    Attributes
    ----------
    scenario : Scenario
        That has it.
    variant, axis : str
        Which.
    velocity : float
        About which it is linearised, m/s.
    frequency : ndarray, shape (lines,)
        Hz.
    """

    scenario: Scenario
    variant: str
    axis: str
    velocity: float
    frequency: Array

    @property
    def config(self) -> ControllerConfig:
        """As it is."""
        return self.scenario.variants[self.variant].controller

    def response(self, shape: Shape) -> Complex:
        """Return C, N/m, of a shape."""
        variant = self.scenario.variants[self.variant]
        changed = with_shape(variant.controller, self.axis, shape)
        alone = {self.variant: variant.model_copy(update={"controller": changed})}
        scenario = self.scenario.model_copy(update={"variants": alone})
        loop = linearise(scenario, self.variant, self.axis, v=self.velocity)
        return loop.controller.response(self.frequency)
