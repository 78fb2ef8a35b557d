"""Slides under a multisine: smooth, at rest at their ends, their sines where they belong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from motionlab.config.multisine import Multisine
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError
from motionlab.timing import CONTROL_PERIOD, to_ticks
from motionlab.trajectories.multisine import lines_of, slides
from motionlab.trajectories.reference import Reference, sample

T = CONTROL_PERIOD


def motion(**fields: Any) -> tuple[Multisine, Reference]:
    config = Multisine.model_validate({"axis": "y", "slides": 6, "lines": 20} | fields)
    return config, sample(config)


def test_velocity_and_acceleration_are_those_of_the_position() -> None:
    _, reference = motion()
    p, v, a = (getattr(reference, name)[:, 1] for name in ("position", "velocity", "acceleration"))
    # Central differences are off by T^2 w^2/6 of a sine: 0.8 at 700 Hz, so only slow ones count.
    _, slow = motion(high=40.0)
    p, v, a = (getattr(slow, name)[:, 1] for name in ("position", "velocity", "acceleration"))
    assert np.abs((p[2:] - p[:-2]) / (2.0 * T) - v[1:-1]).max() < 0.003 * np.abs(v).max()
    assert np.abs((v[2:] - v[:-2]) / (2.0 * T) - a[1:-1]).max() < 0.01 * np.abs(a).max()


def test_it_begins_and_ends_at_rest_where_it_began() -> None:
    config, reference = motion(center={"x": 0.01, "y": -0.02})
    y = reference.position[:, 1]
    assert y[0] == y[-1] == reference.end[1]  # an even number of slides
    assert 0.5 * (y.max() + y.min()) == pytest.approx(-0.02, abs=1e-4)
    assert reference.velocity[0, 1] == reference.velocity[-1, 1] == 0.0
    assert (reference.position[:, 0] == 0.01).all()
    assert len(reference.holds) == config.slides


def test_periods_hold_the_sines_of_their_slide_and_nothing_else() -> None:
    config, reference = motion()
    lines, y = lines_of(config), reference.position[:, 1]
    here = list(slides(config))
    for slide in here:
        way = np.arange(slide.stop - slide.start) * T * config.velocity
        rest = y[slide.start : slide.stop] - (way if slide.forward else -way)
        found = lines.amplitudes(rest - rest.mean())
        assert found.shape == (config.periods, len(lines.cycles))
        assert np.abs(found - slide.amplitudes).max() < 1e-6 * np.abs(slide.amplitudes).max()
    assert [slide.forward for slide in here] == [True, False] * 3
    assert np.abs(np.angle(here[0].amplitudes / here[1].amplitudes)).max() > 0.5


def test_sines_change_the_velocity_by_a_tenth_at_most() -> None:
    config, _ = motion(acceleration=20.0)
    (first, *_) = slides(config)
    speed = np.abs(first.amplitudes) * 2.0 * np.pi * lines_of(config).frequency
    assert np.sqrt(0.5 * (speed**2).sum()) <= 0.1 * config.velocity * (1.0 + 1e-9)


def test_one_that_lasts_too_long_is_refused_before_it_takes_memory() -> None:
    config = Multisine.model_validate({"low": 0.2, "slides": 500, "periods": 100})
    with pytest.raises(ConfigError, match="lasts too long"):
        sample(config)


def test_it_may_be_a_part_of_a_sequence() -> None:
    parts = [{"kind": "multisine", "axis": "y", "slides": 5}, {"kind": "dwell", "duration": 0.5}]
    adapter: TypeAdapter[Any] = TypeAdapter(TrajectoryConfig)
    whole = sample(adapter.validate_python({"kind": "sequence", "parts": parts}))
    assert whole.ticks > 5 * to_ticks(2.5)
    wrong = [{**parts[0], "slides": 6, "for_ever": True}, parts[1]]
    with pytest.raises(ValidationError, match="sequence as a whole"):
        adapter.validate_python({"kind": "sequence", "parts": wrong})


@pytest.mark.parametrize(
    ("fields", "word"),
    [
        ({"low": 10.0, "high": 15.0}, "twice low"),
        ({"slides": 4}, "greater than or equal to 5"),
        ({"axis": "z"}, "'x' or 'y'"),
        ({"slides": 7, "for_ever": True}, "even number of slides"),
        ({"velocity": 0.0}, "greater than 0"),
    ],
)
def test_what_cannot_be_is_refused(fields: dict[str, Any], word: str) -> None:
    with pytest.raises(ValidationError, match=word):
        Multisine.model_validate(fields)
