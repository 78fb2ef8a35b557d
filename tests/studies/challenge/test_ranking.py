"""Laws run, judged and ranked on a part of the challenge, and the page that shows it."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from motionlab.errors import ConfigError
from motionlab.laws import SHIPPED
from motionlab.studies.challenge.documents import LawDocument, report
from motionlab.studies.challenge.entrants import MOST, entrants
from motionlab.studies.challenge.page import challenge_page
from motionlab.studies.challenge.ranking import Challenge, challenge
from tests.studies.challenge.smaller import smaller


@pytest.fixture(scope="module")
def result() -> Challenge:
    """Return a stair, a creep and four motors under the shipped laws and one with a parameter."""
    return challenge(entrants(["canudas-de-wit"], {"gain": 100.0}), of=smaller())


def law_of(result: Challenge, label: str) -> LawDocument:
    return next(law for law in result.document.laws if law.label == label)


def test_shipped_laws_are_there_beside_what_was_named(result: Challenge) -> None:
    laws = result.document.laws
    assert sorted(law.law for law in laws if law.shipped) == sorted(SHIPPED)
    assert [law.label for law in laws if law.entered] == ["canudas-de-wit gain=100.0"]
    assert [law.rank for law in laws] == list(range(1, len(laws) + 1))


def test_off_has_one_throughout(result: Challenge) -> None:
    off = law_of(result, "off")
    assert (off.score, off.error, off.motors, off.effort) == (1.0, 1.0, 1.0, 1.0)
    assert off.verdict == "holds"


def test_a_law_short_of_margins_ranks_below_one_that_holds_and_is_worse(result: Challenge) -> None:
    hold, short = law_of(result, "lugre-observer"), law_of(result, "canudas-de-wit")
    assert hold.score is not None
    assert short.score is not None
    assert short.score < hold.score
    assert short.rank > hold.rank
    assert short.verdict == "short of margins"
    assert short.reasons == ["27.3 of 30 degrees on y of matched"]


def test_a_law_without_linearisation_is_last_and_says_why(result: Challenge) -> None:
    last = result.document.laws[-1]
    assert last.law == "published-k"
    assert last.verdict == "without margins"
    assert last.gain_margin is None
    assert "quotient" in last.reasons[0]


def test_a_law_that_diverges_has_no_score_and_is_last() -> None:
    """A bound of divergence that K as published breaks on the stair, and nobody else."""
    of = smaller("stair")
    tables = of.scenarios["stair"] | {"divergence_error": 5e-5}
    of = dataclasses.replace(of, scenarios={"stair": tables}, on_motors=("stair",), motors=3)
    last = challenge(entrants([], {}), of=of).document.laws[-1]
    assert last.law == "published-k"
    assert last.verdict == "diverges"
    assert last.reasons[:2] == ["diverges in stair", "diverges on 3 of 3 motors of stair"]
    assert last.score is last.error is None
    assert last.scenarios["stair"].axes is None


def test_figures_are_those_of_a_run_and_curves_have_the_same_order(result: Challenge) -> None:
    for number, law in enumerate(result.document.laws):
        axes = law.scenarios["creep"].axes
        assert axes is not None
        for axis, curves in result.curves["creep"].items():
            drawn = max(np.abs(curves.low[number]).max(), np.abs(curves.high[number]).max())
            assert drawn == pytest.approx(axes[axis].max_error)


def test_motors_differ_by_their_seed(result: Challenge) -> None:
    other = challenge(entrants([], {}), of=smaller(), seed=1)
    assert other.document.own_seed
    assert "seed 1" in report(other.document)
    assert not result.document.own_seed
    assert "seed" not in report(result.document)
    ours, theirs = law_of(result, "residual-k"), law_of(other, "residual-k")
    assert ours.error == theirs.error
    assert ours.motors != theirs.motors


def test_its_report_says_where_a_named_law_is(result: Challenge) -> None:
    law = law_of(result, "canudas-de-wit gain=100.0")
    assert report(result.document).endswith(f"gain=100.0: rank {law.rank} of {len(SHIPPED) + 1}")


def test_the_page_holds_ranking_figures_and_digest_and_loads_nothing(result: Challenge) -> None:
    page = challenge_page(result).decode()
    assert "<b>canudas-de-wit gain=100.0</b>" in page
    assert page.count("<svg") == 3 + 1  # stair x, creep x and y; the motors of the stair
    assert result.document.digest in page
    assert not re.search(r"(?:src|href)=", page)
    assert "prefers-color-scheme: dark" in page


def test_the_page_of_the_shipped_laws_has_no_figures_of_one() -> None:
    page = challenge_page(challenge(entrants([], {}), of=smaller("stair"))).decode()
    assert "Challenge 1: shipped laws" in page
    assert "in figures" not in page


def test_what_is_not_there_is_refused() -> None:
    with pytest.raises(ConfigError, match="LAW: no such law, did you mean 'residual-k'"):
        entrants(["residual"], {})
    with pytest.raises(ConfigError, match=r"--set gian: .* did you mean 'gain'"):
        entrants(["canudas-de-wit"], {"gian": 1.0})
    with pytest.raises(ConfigError, match="--set gain: no law that is named"):
        entrants([], {"gain": 1.0})
    with pytest.raises(ConfigError, match=r"--set gain: is out of range; got -1\.0"):
        challenge(entrants(["canudas-de-wit"], {"gain": -1.0}), of=smaller("stair"))


def test_a_shipped_law_that_is_named_is_there_once() -> None:
    named = entrants(["residual-k", "residual-k"], {})
    assert len(named) == len(SHIPPED) <= MOST
    assert [each.law for each in named if each.entered] == ["residual-k"]
