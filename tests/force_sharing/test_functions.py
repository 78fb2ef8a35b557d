"""Laws of force sharing: exact, within limits, least in copper loss where they say so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import minimize

from motionlab.config.controller import SharingConfig, SharingLaw
from motionlab.config.force_map import TableMapConfig
from motionlab.force_sharing.functions import (
    FUNCTIONS,
    PARAMETERS,
    SharingParameters,
    function_number,
)
from motionlab.force_sharing.pole_pitch import Shared, forces_over, share_over
from motionlab.force_sharing.ripple import reachable_over, ripple, share_over_pitch
from motionlab.force_sharing.share import ForceModel, Sharing
from motionlab.kernel.force_maps import force_model
from motionlab.motor_design.kept_maps import named_map
from motionlab.plant.magnetics import AnalyticMap
from motionlab.plant.table_map import ANALYTIC, MotorMap
from motionlab.studies.sharing.map_fit import fit_analytic

Array = NDArray[np.float64]

TAU = 7.2e-3
NOMINAL = AnalyticMap(TAU, 0.0, 34.1, 380.1, 10.0, 5.5, 0.0, 0.0)
SKEWED = AnalyticMap(TAU, 2e-4, 38.4, 427.4, 10.0, 4.0, 0.05, 0.039)
LINEAR = AnalyticMap(TAU, 0.0, 34.1, 380.1, 10.0, 1000.0, 0.0, 0.0)
EVERYWHERE = np.linspace(0.0, TAU, 1201)
OPTIMUM = {"formula": (1e-9, 1e-9), "table": (0.015, 1e-3)}
"""Share by which copper loss may exceed the least that another solver finds: anywhere, mean."""


def analytic(force_map: AnalyticMap, law: SharingLaw, **parameters: float) -> ForceModel:
    sharing = Sharing(function_number(law), -1.0, -1.0, 10.0)
    numbers = {name: each.default for name, each in PARAMETERS.items()} | parameters
    return ForceModel(MotorMap(force_map, ANALYTIC), sharing, SharingParameters(**numbers))


def tabled(name: str, law: SharingLaw) -> ForceModel:
    return force_model(TableMapConfig(name=name), SharingConfig(law=law), 10.0)


def share(model: ForceModel, position: Array, force: Array | float, limit: float = 10.0) -> Shared:
    limited = model._replace(sharing=model.sharing._replace(current_limit=limit))
    return share_over(limited, position=position, force=force)


# -- every law ------------------------------------------------------------------------------------


@given(
    force_map=st.sampled_from([NOMINAL, SKEWED, LINEAR]),
    law=st.sampled_from(list(FUNCTIONS)),
    overlap=st.floats(0.005, 1 / 6),
    force=st.floats(-45.0, 45.0),
    limit=st.floats(1.0, 10.0),
)
def test_currents_stay_in_their_limits_and_give_the_force(
    force_map: AnalyticMap, law: SharingLaw, overlap: float, force: float, limit: float
) -> None:
    model = analytic(force_map, law, overlap=overlap, rise=overlap)
    shared = share(model, EVERYWHERE, force, limit)
    assert shared.current.min() >= 0.0
    assert shared.current.max() <= limit * (1.0 + 1e-12)
    given = forces_over(MotorMap(force_map, ANALYTIC), position=EVERYWHERE, current=shared.current)
    assert shared.force == pytest.approx(given.thrust, abs=1e-9)
    free = ~shared.limited
    assert shared.force[free] == pytest.approx(np.full(free.sum(), force), rel=1e-8, abs=1e-9)
    assert (np.abs(shared.force) <= abs(force) * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("law", FUNCTIONS)
@pytest.mark.parametrize("name", ["new-design", "previous-design"])
def test_what_is_out_of_reach_is_told(name: str, law: SharingLaw) -> None:
    model = tabled(name, law)
    for forward in (True, False):
        reach = reachable_over(model, position=EVERYWHERE, forward=forward)
        sign = 1.0 if forward else -1.0
        below = share(model, EVERYWHERE, sign * (reach - 0.05))
        beyond = share(model, EVERYWHERE, sign * (reach + 0.05))
        assert not below.limited.any()
        assert beyond.limited.all()
        assert below.force == pytest.approx(sign * (reach - 0.05), abs=0.15)


def test_the_general_kernel_shares_as_the_closed_form() -> None:
    """On the analytic map, whatever the table kernel computes beside."""
    force = 33.0
    closed = share(analytic(SKEWED, "least-norm"), EVERYWHERE, force)
    beside = tabled("new-design", "least-norm")
    general = share(beside._replace(map=MotorMap(SKEWED, ANALYTIC)), EVERYWHERE, force)
    assert general.current == pytest.approx(closed.current, rel=1e-9, abs=1e-7)
    assert general.force == pytest.approx(closed.force, rel=1e-9)
    assert (general.limited == closed.limited).all()


def test_linear_up_to() -> None:
    """What the documentation prints for the nominal motor."""
    found = {
        law: reachable_over(analytic(NOMINAL, law), position=EVERYWHERE, forward=True).min()
        for law in FUNCTIONS
    }
    expected = {"least-norm": 27.30, "force-per-ampere": 29.53, "sine": 27.99, "cubic": 28.21}
    expected["least-normal-force"] = expected["force-per-ampere"]
    assert found == pytest.approx(expected, abs=0.01)


# -- least copper loss ----------------------------------------------------------------------------


def least_loss(model: ForceModel, position: float, force: float, start: Array) -> float:
    """Return the least sum of squared currents that gives a force, by an independent solver."""

    def thrusts(i: Array) -> Array:
        """Return what each column of currents gives beyond the force."""
        current = np.clip(i, 0.0, 10.0)
        place = np.full(current.shape[1], position)
        return forces_over(model.map, position=place, current=current).thrust - force

    def thrust(i: Array) -> float:
        return float(thrusts(i[:, None])[0])

    def slopes(i: Array) -> Array:
        """Return the slopes of the thrust, by steps away from the limits."""
        steps = np.where(i < 5.0, 1e-7, -1e-7)
        here, *there = thrusts(i[:, None] + np.hstack([np.zeros((3, 1)), np.diag(steps)]))
        return (np.array(there) - here) / steps

    best = np.inf
    pulling = [k for k in range(3) if thrust(10.0 * np.eye(3)[k]) * force > -force * force]
    starts = [start, np.full(3, 3.0), *(8.0 * np.eye(3)[k] + 0.5 for k in pulling)]
    for first in starts:
        found = minimize(
            lambda i: (i * i).sum(),
            first,
            method="SLSQP",
            jac=lambda i: 2.0 * i,
            bounds=[(0.0, 10.0)] * 3,
            constraints={"type": "eq", "fun": thrust, "jac": slopes},
            options={"ftol": 1e-12, "maxiter": 100},
        )
        if found.success and abs(thrust(found.x)) < 1e-6 * abs(force):
            best = min(best, float(found.fun))
    return best


@pytest.mark.parametrize(
    ("model", "kind"),
    [
        (analytic(NOMINAL, "force-per-ampere"), "formula"),
        (analytic(SKEWED, "force-per-ampere"), "formula"),
        (tabled("new-design", "force-per-ampere"), "table"),
        (tabled("previous-design", "force-per-ampere"), "table"),
    ],
)
def test_copper_loss_is_not_beaten(model: ForceModel, kind: str) -> None:
    random = np.random.Generator(np.random.Philox(21))
    position = random.uniform(0.0, 0.009, 40)
    force = random.uniform(-29.0, 29.0, 40)
    shared = share(model, position, force)
    loss = (shared.current**2).sum(axis=0)
    more = [
        loss[k] / least - 1.0
        for k in np.flatnonzero(~shared.limited)
        if np.isfinite(
            least := least_loss(model, position[k], shared.force[k], shared.current[:, k])
        )
    ]
    assert len(more) > 30
    assert max(more) < OPTIMUM[kind][0]
    assert np.mean(more) < OPTIMUM[kind][1]


@pytest.mark.parametrize("law", [law for law, each in FUNCTIONS.items() if each.passes_on])
def test_what_one_phase_cannot_give_another_does(law: SharingLaw) -> None:
    model = analytic(NOMINAL, law)
    reach = reachable_over(model, position=EVERYWHERE, forward=True)
    whole = share(model, EVERYWHERE, 1e3)
    assert whole.force == pytest.approx(reach, rel=1e-6)
    at_limit = np.isclose(whole.current, 10.0, rtol=1e-9)
    assert (at_limit | (whole.current < 1e-6)).all()


@pytest.mark.parametrize("law", [law for law in FUNCTIONS if law != "force-per-ampere"])
@pytest.mark.parametrize("force", [2.0, 12.0, 25.0])
def test_no_law_loses_less_than_force_per_ampere(law: SharingLaw, force: float) -> None:
    for best, other in (
        (analytic(NOMINAL, "force-per-ampere"), analytic(NOMINAL, law)),
        (tabled("new-design", "force-per-ampere"), tabled("new-design", law)),
    ):
        least = (share(best, EVERYWHERE, force).current ** 2).sum(axis=0)
        loss = (share(other, EVERYWHERE, force).current ** 2).sum(axis=0)
        assert loss.mean() > least.mean()
        assert (loss > least * (1.0 - 5e-3) - 1e-3).all()


# -- least normal force ---------------------------------------------------------------------------


def normal_force(model: ForceModel, force: float) -> Array:
    current = share(model, EVERYWHERE, force).current
    return forces_over(model.map, position=EVERYWHERE, current=current).normal


def least_normal(force: float) -> Array:
    """Return the least normal force of a thrust, N, by every split between two phases."""
    turns = np.mod(EVERYWHERE / TAU - np.arange(3)[:, None] / 3.0, 1.0)
    angle = 2.0 * np.pi * np.sort(turns, axis=0)[:2]
    most = np.maximum(34.1 * np.sin(angle), 0.0)
    first = np.linspace(0.0, 1.0, 2001)[:, None] * np.minimum(most[0], force)
    per_thrust = 380.1 / 34.1 * 0.5 * np.tan(0.5 * np.minimum(angle, 3.1))
    second = force - first
    normal = first * per_thrust[0] + second * per_thrust[1]
    return np.where(second <= most[1] + 1e-9, normal, np.inf).min(axis=0)


@pytest.mark.parametrize("force", [2.0, 5.0, 10.0, 20.0])
def test_least_normal_force_is_near_the_least(force: float) -> None:
    least = least_normal(force)
    by_law = {law: normal_force(analytic(NOMINAL, law), force) for law in FUNCTIONS}
    assert all((normal > least - 0.01 * least.mean()).all() for normal in by_law.values())
    own = by_law.pop("least-normal-force")
    assert least.mean() < own.mean() < 1.08 * least.mean()
    assert own.mean() < 0.75 * min(normal.mean() for normal in by_law.values())
    sharper = normal_force(analytic(NOMINAL, "least-normal-force", rise=0.005), force)
    assert sharper.mean() < 1.012 * least.mean()


@pytest.mark.parametrize("name", ["new-design", "previous-design"])
@pytest.mark.parametrize("force", [-20.0, 2.0, 10.0])
def test_least_normal_force_saves_on_a_table(name: str, force: float) -> None:
    means = {law: normal_force(tabled(name, law), force).mean() for law in FUNCTIONS}
    own = means.pop("least-normal-force")
    assert 0.02 < 1.0 - own / min(means.values()) < 0.12


def test_the_currents_of_least_normal_force_have_finite_slopes() -> None:
    """Ten times finer steps find the same slope; least norm's begin with the root of a distance."""

    def steepest(law: SharingLaw, force: float, step: float) -> float:
        place = np.arange(0.0, TAU, step)
        return float(np.abs(np.diff(share(analytic(NOMINAL, law), place, force).current)).max())

    for force in (1.0, 5.0, -12.0, 20.0, 25.0):
        coarse, fine = (steepest("least-normal-force", force, step) for step in (2e-6, 2e-7))
        assert 35e3 < fine / 2e-7 < 58.5e3
        assert fine / 2e-7 < 1.05 * coarse / 2e-6
    assert (
        steepest("least-norm", 20.0, 2e-7) / 2e-7 > 2.0 * steepest("least-norm", 20.0, 2e-6) / 2e-6
    )


# -- sharing functions ----------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["sine", "cubic"])
def test_a_sharing_function_hands_over_as_it_says(law: SharingLaw) -> None:
    overlap = 0.1
    turns = np.linspace(0.0, 1.0, 2401)
    shared = share(analytic(NOMINAL, law, overlap=overlap), turns * TAU, 10.0)
    x = np.sin(2.0 * np.pi * (turns - np.arange(3)[:, None] / 3.0))
    q = (shared.current / 10.0) ** 2
    B = (10.0 / 5.5) ** 2
    part = 34.1 * (1.0 + B) * q / (1.0 + B * q) * x / 10.0
    assert part.sum(axis=0) == pytest.approx(np.ones_like(turns), abs=1e-9)
    start = 1 / 12 - overlap / 2
    z = np.clip((turns - start) / overlap, 0.0, 1.0)
    rise = 0.5 * (1.0 - np.cos(np.pi * z)) if law == "sine" else z * z * (3.0 - 2.0 * z)
    taking_over = (turns > start) & (turns < start + 1 / 3)
    assert part[0][taking_over] == pytest.approx(rise[taking_over], abs=1e-9)
    assert (part[0][(turns < start) | (turns > start + 1 / 3 + overlap)] == 0.0).all()


# -- over a pitch, and fits -----------------------------------------------------------------------


def test_ripple_is_that_of_the_plants_map() -> None:
    stronger = NOMINAL._replace(F_pk=40.0)
    over = share_over_pitch(
        analytic(NOMINAL, "least-norm"),
        MotorMap(stronger, ANALYTIC),
        force=-15.0,
        points=120,
    )
    assert over.thrust == pytest.approx(np.full(120, -15.0 * 40.0 / 34.1))
    assert over.believed == pytest.approx(np.full(120, -15.0))
    assert over.phase_thrust.sum(axis=0) == pytest.approx(over.thrust)
    assert ripple(over.thrust).peak_to_peak == pytest.approx(0.0, abs=1e-9)
    skewed = share_over_pitch(
        analytic(NOMINAL, "least-norm"),
        MotorMap(SKEWED, ANALYTIC),
        force=15.0,
        points=120,
    )
    found = ripple(skewed.thrust)
    assert found.peak_to_peak == pytest.approx(np.ptp(skewed.thrust))
    assert found.relative == pytest.approx(found.peak_to_peak / skewed.thrust.mean())


def test_a_fit_is_the_best_of_its_kind() -> None:
    table = named_map("new-design")
    fit = fit_analytic(table)
    x, i = np.meshgrid(np.linspace(-0.5, 0.5, 96, endpoint=False) * TAU, np.arange(1, 41) / 4.0)
    wanted = table.thrust(x, i)

    largest = np.abs(wanted).max(axis=1, keepdims=True)

    def rms(force_map: AnalyticMap) -> float:
        current = np.stack([i.ravel(), 0 * i.ravel(), 0 * i.ravel()])
        place = x.ravel() + TAU / 2
        found = forces_over(MotorMap(force_map, ANALYTIC), position=place, current=current).thrust
        return float(np.sqrt((((found.reshape(x.shape) - wanted) / largest) ** 2).mean()))

    assert rms(fit.force_map) == pytest.approx(fit.relative_rms, rel=1e-6)
    assert fit.relative_rms < 0.12
    assert 0.5 * fit.worst < 2.0 * fit.rms < fit.worst < 9.0
    for field in ("F_pk", "I_knee"):
        for factor in (0.97, 1.03):
            value = factor * getattr(fit.force_map, field)
            assert rms(fit.force_map._replace(**{field: value})) > fit.relative_rms
    for field in ("h_2", "h_3"):
        for step in (-0.02, 0.02):
            value = step + getattr(fit.force_map, field)
            assert rms(fit.force_map._replace(**{field: value})) > fit.relative_rms
    assert rms(NOMINAL) > 1.5 * fit.relative_rms
