"""What a motion asks for, in one compiled pass, is what numpy finds array by array."""

from dataclasses import replace

import numpy as np
import pytest
from pydantic import TypeAdapter

from motionlab.config.load import epochs, load_scenario
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.simulation.prepare import limit_sets
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_limits import QUANTITIES, UNITS, Span, demands
from motionlab.trajectories.reference import Reference, sample

ADAPTER: TypeAdapter = TypeAdapter(TrajectoryConfig)
LIMITS = limit_sets(tuple(epochs(load_scenario("circle"))))[0][1]
CORNERS = [[0.09, 0.0], [0.02, 0.03], [0.01, 0.031], [0.0, -0.15]]
MOTIONS = {
    "in reach": {"points": [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0]], "v_max": 0.08, "a_max": 0.8},
    "out of the stroke": {"points": CORNERS, "v_max": 0.3, "a_max": 2.0},
    "too much of everything": {"points": CORNERS, "v_max": 3.0, "a_max": 30.0},
    "corners at speed": {"points": CORNERS, "law": "constant_speed", "v_max": 0.2, "a_max": 1.0},
    "smooth": {"points": CORNERS, "geometry": "spline", "v_max": 0.5, "a_max": 9.0},
}


def motion(name: str) -> Reference:
    table = {"kind": "path", "closed": True, "laps": 2, "dwell": 0.01}
    return sample(ADAPTER.validate_python(table | MOTIONS[name]))


def plainly(reference: Reference, axis: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return value and limit of each quantity, tick by tick, of the position with its end."""
    p, v, a = (
        values[:, axis]
        for values in (reference.position, reference.velocity, reference.acceleration)
    )
    before = np.concatenate(([0.0], v[:-1]))
    mean = (v - before) / CONTROL_PERIOD
    way = np.diff(p, prepend=p[0])
    low, high = (CONTROL_PERIOD * f(v, before) for f in (np.minimum, np.maximum))
    jump = way - np.clip(way, low, high)
    jump[0] = 0.0
    thrust = LIMITS.mass[axis] * a + LIMITS.friction(axis, v)
    sure = LIMITS.sure_thrust[axis]
    available = LIMITS.available_thrust(axis, p, np.where(thrust < 0.0, -1.0, 1.0))
    available = np.where(np.abs(thrust) > sure, available, sure)
    values = (
        np.append(p, reference.end[axis]),
        jump,
        v,
        np.where(np.abs(a) >= np.abs(mean), a, mean),
        thrust,
    )
    fixed = (LIMITS.stroke[axis], 10e-6, LIMITS.v_max[axis], LIMITS.a_max[axis])
    limits = [np.full_like(value, limit) for value, limit in zip(values, fixed, strict=False)]
    return list(zip(values, [*limits, available], strict=True))


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("name", MOTIONS)
def test_flags_intervals_and_peaks(name, axis):
    reference = motion(name)
    demand = demands(reference, LIMITS)[axis]
    flags = 0
    for quantity, (value, limit) in enumerate(plainly(reference, axis)):
        slack = 1e-12 if UNITS[quantity] == "m" else 1e-9 * limit.max()
        beyond = np.abs(value) > limit + slack
        bits = demand.beyond[: len(value)] >> quantity & 1
        assert np.array_equal(bits, beyond)
        asked = np.abs(value) / (limit if QUANTITIES[quantity] == "thrust" else 1.0)
        assert demand.peaks[quantity] == np.argmax(asked)
        found = demand.outside(quantity)
        assert (found is not None) == bool(beyond.any())
        flags |= int(beyond.any()) << quantity
        if found is None:
            continue
        edges = np.flatnonzero(np.diff(beyond, prepend=False, append=False)).reshape(-1, 2)
        assert np.array_equal(np.stack((found.start, found.stop), axis=1), edges)
        for i, (start, stop) in enumerate(edges):
            worst = start + int(np.argmax((np.abs(value) - limit)[start:stop]))
            assert found.worst[i] == worst
            assert (found.value[i], found.limit[i]) == (value[worst], limit[worst])
            assert demand.value_at(quantity, worst) == value[worst]
            assert demand.limit_at(quantity, worst) == limit[worst]
    assert demand.violations == flags


def test_limits_say_nothing_of_the_ticks_at_which_they_do_not_hold():
    reference = motion("too much of everything")
    middle = reference.ticks // 2
    whole, before, after = (
        demands(reference, LIMITS, span=span)[0].beyond
        for span in (Span(), Span(end=middle), Span(middle))
    )
    assert whole[:middle].any()
    assert whole[middle:].any()
    assert np.array_equal(np.concatenate((before[:middle], after[middle:])), whole)
    assert not before[middle:].any()
    assert not after[:middle].any()


def test_the_end_of_the_motion_is_held_against_the_stroke():
    line = {"kind": "line", "end": {"x": 0.08}, "v_max": 0.1, "a_max": 1.0, "dwell": 0.0}
    reference = sample(ADAPTER.validate_python(line))
    largest = float(reference.position[:, 0].max())
    limits = replace(LIMITS, stroke=(np.nextafter(0.08, 0.0) - 2e-12, 0.145))
    assert largest < limits.stroke[0]
    found = demands(reference, limits)[0].outside(QUANTITIES.index("position"))
    assert found is not None
    assert found.start.tolist() == found.worst.tolist() == [reference.ticks]
    assert found.value.tolist() == [reference.end[0]]


def test_the_sign_of_a_rounded_velocity_takes_no_thrust():
    reference = motion("in reach")
    noise = np.array(1e-10 * (-1.0) ** np.arange(reference.ticks), dtype=np.float64)
    still = np.zeros(reference.ticks)
    resting = replace(
        reference,
        velocity=np.stack([noise, reference.velocity[:, 1]], axis=1),
        acceleration=np.stack([still, reference.acceleration[:, 1]], axis=1),
    )
    assert np.ptp(LIMITS.friction(0, noise)) > 1.0
    found = demands(resting, LIMITS)
    assert not found[0].samples.thrust.any()
    assert found[1].samples.thrust.any()
