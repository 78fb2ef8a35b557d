"""Sizing gives the paper's figures, and says where the paper's own forms do not."""

from __future__ import annotations

import pytest

from motionlab.motor_design.design import design
from motionlab.motor_design.document import AxisRating, DesignDocument, Rating, Reading


@pytest.fixture(scope="module")
def paper() -> DesignDocument:
    return design({})


@pytest.fixture(scope="module")
def rating(paper: DesignDocument) -> Rating:
    assert paper.rating is not None
    return paper.rating


def shown(value: float | None, digits: str) -> str:
    assert value is not None
    return format(value, digits)


# Reading of sizing, its printed and its used value as text, the factor to the text's unit.
SIZED = [
    ("P_max", "32.0", "32.0", 1.0, ".1f"),
    ("tau", "7.2", "7.2", 1e3, ".1f"),
    ("sigma", "1", "1", 1.0, ".6g"),
    ("w", "18.0", "39.6", 1e3, ".1f"),
    ("N", "144.17", "145.00", 1.0, ".2f"),
    ("A", "80.6", "36.6", 1e-3, ".1f"),
    ("K_1", "5", "11", 1.0, ".6g"),
    ("l_m", "93.1", "42.3", 1e3, ".1f"),
    ("lambda_needed", "3.687", "1.495", 1.0, ".3f"),
    ("A_g", "502.5", "228.4", 1e6, ".1f"),
    ("dt", "3.6", "3.6", 1e3, ".1f"),
    ("u", "4.57", "4.57", 1.0, ".2f"),
]

# The same of rating.
RATED = [
    ("P_specified", "32.0", "32.0", 1.0, ".1f"),
    ("w", "18.0", "39.6", 1e3, ".1f"),
    ("A_g", "228.4", "228.4", 1e6, ".1f"),
    ("A", "80.6", "36.6", 1e-3, ".1f"),
    ("N_needed", "144.17", "144.17", 1.0, ".2f"),
    ("K_1", "5", "11", 1.0, ".6g"),
    ("lambda_needed", "3.687", "1.495", 1.0, ".3f"),
    ("P_max", "14.5", "32.0", 1.0, ".1f"),
    ("f_max", "14.5", "32.0", 1.0, ".1f"),
]

# Axis, reading, printed, used.
OF_AN_AXIS = [
    ("x", "velocity_single_phase", "1.01", "1.01"),
    ("y", "velocity_single_phase", "0.89", "0.84"),
    ("x", "velocity_two_phase", "1.58", "1.58"),
    ("y", "velocity_two_phase", "1.34", "1.34"),
    ("x", "acceleration", "7.31", "7.31"),
    ("y", "acceleration", "3.10", "3.10"),
    ("x", "mass_for_printed_velocity", "5.70", "5.68"),
    ("y", "mass_for_printed_velocity", "13.90", "12.48"),
]


@pytest.mark.parametrize(("key", "printed", "used", "factor", "digits"), SIZED)
def test_sizing_of_the_example(
    paper: DesignDocument, key: str, printed: str, used: str, factor: float, digits: str
) -> None:
    found: Reading = getattr(paper.sizing, key)
    assert shown((found.printed_value or 0.0) * factor, digits) == printed
    assert shown((found.value or 0.0) * factor, digits) == used


@pytest.mark.parametrize(("key", "printed", "used", "factor", "digits"), RATED)
def test_rating_of_the_example(
    rating: Rating, key: str, printed: str, used: str, factor: float, digits: str
) -> None:
    found: Reading = getattr(rating, key)
    assert shown((found.printed_value or 0.0) * factor, digits) == printed
    assert shown((found.value or 0.0) * factor, digits) == used


@pytest.mark.parametrize(("axis", "key", "printed", "used"), OF_AN_AXIS)
def test_velocities_and_accelerations(
    rating: Rating, axis: str, key: str, printed: str, used: str
) -> None:
    found: Reading = getattr(getattr(rating, axis), key)
    assert shown(found.printed_value, ".2f") == printed
    assert shown(found.value, ".2f") == used


def test_from_rest_to_rest_y_is_too_slow_for_its_specification(rating: Rating) -> None:
    assert shown(rating.x.velocity_two_phase_rest_to_rest.value, ".2f") == "1.11"
    assert shown(rating.y.velocity_two_phase_rest_to_rest.value, ".3f") == "0.948"
    assert len(rating.warnings) == 2
    assert all(warning.startswith("y reaches 0.") for warning in rating.warnings)


def test_nothing_of_sizing_is_warned_of(paper: DesignDocument) -> None:
    assert paper.sizing.warnings == []


def test_the_turns_as_sized_reach_the_flux_density(rating: Rating) -> None:
    assert shown(rating.B_g_reached.value, ".3f") == "1.517"


def test_turns_that_the_iron_uses_up_leave_no_flux_density() -> None:
    rating = design({"dimensions": {"N": 72}}).rating
    assert rating is not None
    assert rating.B_g_reached.value == 0.0


def test_the_change_of_flux_linkage_is_that_of_the_inductances(rating: Rating) -> None:
    L_a, L_u = rating.L_a.value, rating.L_u.value
    assert L_a is not None
    assert L_u is not None
    assert rating.dpsi.value == pytest.approx((L_a - L_u) * 10.0)
    assert rating.psi.value == pytest.approx(L_a * 10.0)
    assert shown(L_a * 1e3, ".2f") == "4.97"


def test_the_gap_area_with_bars_is_told(rating: Rating) -> None:
    assert "456.8 mm^2" in rating.A_g.remark
    assert "square posts" in rating.A_g.remark


def test_voltage_times_current_is_the_power_with_the_whole_width(rating: Rating) -> None:
    power = 0.7 * 1.0 * 10.0 * (rating.u.value or 0.0)
    assert power == pytest.approx(rating.P_max.value, rel=1e-12)
    assert power == pytest.approx(32.0, rel=1e-4)
    assert rating.P_max.printed_value == pytest.approx(power * 5 / 11)


def test_with_the_printed_lambda_the_printed_form_gives_the_printed_stack() -> None:
    sizing = design({"requirements": {"lambda": 3.687}}).sizing
    assert shown((sizing.l_m.printed_value or 0.0) * 1e3, ".1f") == "42.3"
    assert shown((sizing.l_m.value or 0.0) * 1e3, ".1f") == "19.2"


def test_the_masses_behind_the_velocities_are_told(rating: Rating) -> None:
    assert "5.7 kg" in rating.x.velocity_single_phase.remark
    assert "0.991 m/s" in rating.x.velocity_single_phase.remark
    assert "0.89 m/s needs 12.5 kg" in rating.y.velocity_single_phase.remark


def readings(section: Rating | AxisRating | DesignDocument) -> list[Reading]:
    found: list[Reading] = []
    for _, value in section:
        if isinstance(value, Reading):
            found.append(value)
        elif hasattr(value, "model_fields_set"):
            found += readings(value)
    return found


def test_where_two_values_differ_a_remark_says_why(paper: DesignDocument) -> None:
    for found in readings(paper):
        assert found.used_form
        if found.printed_value is not None:
            assert found.printed_form
            if found.value != pytest.approx(found.printed_value, rel=2e-3):
                assert found.remark, found.quantity
                assert found.used_form != found.printed_form


# -- other machines -------------------------------------------------------------------------------


def test_one_limb_has_no_two_readings() -> None:
    document = design({"requirements": {"limbs": 1}, "dimensions": {"limbs": 1}})
    assert document.rating is not None
    for section in (document.sizing, document.rating):
        for key in ("w", "A", "K_1", "lambda_needed"):
            found: Reading = getattr(section, key)
            assert found.value == pytest.approx(found.printed_value, rel=1e-12), key
    assert document.sizing.l_m.value == pytest.approx(document.sizing.l_m.printed_value)
    # One limb's consistent lambda is that of two: w/tau and N i/w cancel.
    assert document.rating.lambda_needed.value == pytest.approx(1.49534, abs=1e-5)


def test_measured_force() -> None:
    rating = design({"dimensions": {"single_phase_force": 38.4}}).rating
    assert rating is not None
    assert rating.x.velocity_single_phase.printed_value is None  # printed for 34.1 N
    assert rating.x.velocity_single_phase.value == pytest.approx((38.4 * 0.17 / 5.7) ** 0.5)
    assert rating.x.mass_for_printed_velocity.value is None


def test_a_mass_that_is_given_is_the_platform_too() -> None:
    document = design({"dimensions": {"x": {"mass": 8.0}}})
    assert document.rating is not None
    assert document.dimensions is not None
    assert document.dimensions.x.platform_mass == 8.0
    assert document.dimensions.x.stroke == 0.17
    assert document.rating.x.velocity_single_phase.value == pytest.approx((34.1 * 0.17 / 8) ** 0.5)
    assert document.rating.x.acceleration.printed_value is None
    assert document.rating.y.acceleration.printed_value == 3.10


def test_the_other_direction_is_left_alone() -> None:
    document = design({"requirements": {"tau": 9e-3}})
    assert document.requirements.tau == 9e-3
    assert document.dimensions is not None
    assert document.dimensions.tau == 7.2e-3


def test_teeth_from_whatever_is_given() -> None:
    for given in (
        {"sigma": 0.5},
        {"p": 2.4e-3},
        {"s": 4.8e-3},
        {"p": 2.4e-3, "s": 4.8e-3, "sigma": 0.5},
    ):
        used = design({"requirements": given}).requirements
        assert (used.p, used.s, used.sigma) == pytest.approx((2.4e-3, 4.8e-3, 0.5)), given


def test_what_a_machine_cannot_do_is_warned_of() -> None:
    rating = design(
        {"dimensions": {"N": 100, "f_max": 200.0, "loading_max": 25.2e3, "v_max": 0.5}}
    ).rating
    assert rating is not None
    assert rating.lambda_needed.value is None
    assert rating.lambda_needed.printed_value is None
    assert [warning.split(" ")[0] for warning in rating.warnings] == [
        "electric",
        "N",
        "no",
        "single_phase_force",
    ]


@pytest.mark.parametrize(("current", "warned"), [(6.7, True), (6.9, False), (24.5, False)])
def test_electric_loading_has_a_range(current: float, warned: bool) -> None:
    rating = design({"dimensions": {"i": current}}).rating
    assert rating is not None
    loading = 145 * current / 0.0396
    assert rating.A.value == pytest.approx(loading)
    assert warned == any(w.startswith("electric loading") for w in rating.warnings)
    assert warned == (not 25e3 <= loading <= 90e3)


# -- the design before ----------------------------------------------------------------------------


def test_the_previous_design_as_far_as_the_paper_tells() -> None:
    document = design({"preset": "previous"})
    used = document.requirements
    assert (used.tau, used.n, used.p, used.s) == (9e-3, 2, 4.5e-3, 4.5e-3)
    assert document.sizing.w.value == pytest.approx(31.5e-3)
    assert document.sizing.w.printed_value == pytest.approx(13.5e-3)
    assert document.dimensions is None
    assert document.rating is None
    assert "tau = 9 mm and n = 2 only" in document.notes[0]


def test_the_previous_design_with_dimensions_of_ones_own() -> None:
    axis = {"mass": 6.0, "stroke": 0.1}
    document = design(
        {
            "preset": "previous",
            "dimensions": {
                "l_m": 0.06,
                "N": 145,
                "single_phase_force": 30.0,
                "two_phase_force": 40.0,
                "x": axis,
                "y": axis,
            },
        }
    )
    assert document.dimensions is not None
    assert document.rating is not None
    assert (document.dimensions.tau, document.dimensions.n) == (9e-3, 2)
    assert document.rating.w.value == pytest.approx(31.5e-3)
    assert document.rating.x.velocity_single_phase.printed_value is None
