"""Reports: what they show is the run, whatever its names are."""

from __future__ import annotations

import base64
import hashlib
import math
import re
import shlex
import tomllib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from motionlab.analysis.comparison_options import Comparing
from motionlab.analysis.metrics import DEFINITIONS
from motionlab.cli.main import main
from motionlab.config.load import load_scenario
from motionlab.exchange.measurements.document import ImportOptions
from motionlab.exchange.measurements.runs import import_file
from motionlab.library.library import library
from motionlab.library.run import Event, RunDetail
from motionlab.reports.recipe import recipe
from motionlab.reports.run_reports import comparison_report, run_report
from motionlab.reports.svg_plane import plane
from motionlab.telemetry.decimate import min_max
from tests.library.test_replay import altered, keep, rewrite

HOSTILE = "<script>alert('1')</script> \"&amp; \x01"
SIZE_MAX = 2_000_000
DATA = re.compile("[A-Za-z0-9+/=]+")
VOID = {"meta", "br"}
SVG = "{http://www.w3.org/2000/svg}"


class Page(HTMLParser):
    """Texts, exact numbers and elements of a page, whose elements must all be closed."""

    def __init__(self, content: bytes) -> None:
        super().__init__()
        self.text: list[str] = []
        self.values: list[float] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.scripts: list[str] = []
        self._open: list[str] = []
        source = content.decode()
        self.feed(source)
        self.close()
        assert self._open == []
        assert len(content) < SIZE_MAX
        self.svgs = [
            ElementTree.fromstring(svg) for svg in re.findall(r"<svg.*?</svg>", source, re.DOTALL)
        ]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs
        if tag == "data":
            self.values.append(float(dict(attrs)["value"] or "nan"))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        (self.scripts if self._open[-1:] == ["script"] else self.text).append(data)

    @property
    def whole(self) -> str:
        return " ".join(self.text)

    def plot(self, title: str) -> ElementTree.Element:
        return next(svg for svg in self.svgs if svg.findtext(f"{SVG}title") == title)


def check_nothing_is_loaded(page: Page) -> None:
    assert not {"img", "link", "iframe", "object", "use", "a"} & set(page.tags)
    loading = {"src", "href", "xlink:href", "srcset", "action", "onload", "onerror", "onclick"}
    assert not loading & {name for name, _ in page.attributes}
    assert "url(" not in page.whole
    assert "@import" not in page.whole
    policies = [str(value) for name, value in page.attributes if name == "content"]
    for script in page.scripts:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        known = any(f"script-src 'sha256-{digest}'" in policy for policy in policies)
        assert known or DATA.fullmatch(script)


def numbers_of(svg: ElementTree.Element) -> tuple[float, float]:
    """Return place of zero and places per unit shown, of the value axis, as its ticks say."""
    ticks = [text for text in svg.iter(f"{SVG}text") if text.get("class") == "y"]
    value = [float(re.match(r"[\d.-]+", (t.text or "").replace("\u2212", "-"))[0]) for t in ticks]  # pyright: ignore[reportOptionalSubscript]
    place = [float(text.get("y") or "nan") - 4.0 for text in ticks]
    slope = (place[-1] - place[0]) / (value[-1] - value[0])
    return place[0] - slope * value[0], slope


def ends_of(svg: ElementTree.Element, look: str) -> tuple[float, float]:
    """Return least and largest value of a curve, in the unit of its axis."""
    paths = [p.get("d") or "" for p in svg.iter(f"{SVG}path") if p.get("class") == f"curve {look}"]
    drawn = max(paths, key=len)  # not the swatch
    places = [float(y) for y in re.findall(r"(?:[ML]\S+ |V)([\d.-]+)", drawn)]
    zero, slope = numbers_of(svg)
    values = [(place - zero) / slope for place in places]
    return min(values), max(values)


@pytest.fixture(scope="module")
def kept() -> RunDetail:
    return keep({"variants.B.controller.x.k_p": 210_000.0})


@pytest.fixture(scope="module")
def page(kept: RunDetail) -> Page:
    return Page(run_report(kept.id))


def test_its_numbers_are_the_metrics_of_the_run(kept: RunDetail, page: Page) -> None:
    wanted = [
        values["axes"][axis][name]
        for name in DEFINITIONS
        for axis in ("x", "y")
        for values in kept.result["variants"].values()
    ]
    contour = [
        v["contour"][name] for name in ("max", "rms") for v in kept.result["variants"].values()
    ]
    wanted = [value for value in wanted + contour if value is not None]
    assert page.values[: len(wanted)] == wanted
    for definition in DEFINITIONS.values():
        used = kept.result["variants"]["A"]["axes"]["x"].get("settling_time") is not None
        if used or "hold" not in definition.meaning:
            assert definition.meaning in page.whole


def test_it_says_what_was_done(kept: RunDetail, page: Page) -> None:
    assert "variants.B.controller.x.k_p" in page.whole
    assert "200.3 N/mm" in page.whole.replace("  ", " ")
    assert kept.model in page.whole
    assert kept.processor in page.whole
    assert library().files.digest(kept.id) in page.whole
    assert "phase margin" in page.whole
    check_nothing_is_loaded(page)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_curves_pass_through_the_extremes(kept: RunDetail, page: Page, axis: str) -> None:
    svg = page.plot(f"Following error {axis}")
    with library().files.open(kept.id) as file:
        for variant, look in (("A", "a"), ("B", "b")):
            name = f"{variant}.{axis}.following_error"
            samples = file.read([name])[name].to_numpy() * 1e6
            least, most = ends_of(svg, look)
            assert least == pytest.approx(samples.min(), abs=0.01)
            assert most == pytest.approx(samples.max(), abs=0.01)


def test_a_spike_of_one_sample_is_drawn() -> None:
    """One that is not among the samples that a plot of every nth would have."""
    spiked = keep()
    rewrite(spiked, lambda table: altered(table, 1001, "A.x.following_error", 1e-3))
    least, most = ends_of(Page(run_report(spiked.id)).plot("Following error x"), "a")
    assert most == pytest.approx(1.0, abs=1e-3)
    assert least > -0.1


def test_hostile_names_are_text(kept: RunDetail) -> None:
    changes = {"name": HOSTILE, "note": HOSTILE, "tags": []}
    label = keep({"variants.A.label": "<script>'\"</script>"})
    library().change(label.id, changes)
    for content in (
        run_report(label.id),
        comparison_report(label.id, kept.id, Comparing(exact=True, only=["*.following_error"])),
    ):
        page = Page(content)
        check_nothing_is_loaded(page)
        assert "<script>alert('1')</script> \"&amp; \ufffd" in page.whole
        assert b"<script>alert" not in content
        assert b"<script>'" not in content
        assert any("<script>'\"</script>" in "".join(svg.itertext()) for svg in page.svgs) or (
            "variants.A.label" in page.whole
        )


def test_the_recipe_gives_the_same_scenario(kept: RunDetail) -> None:
    assert kept.scenario_document is not None
    for changes in ({}, {"variants.B.controller.x.k_p": 2.1e5}, {"trajectory": "rhombus"}):
        scenario = load_scenario("circle", changes)
        made = recipe(scenario)
        again = load_scenario(tomllib.loads(made.toml or ""))
        assert again.model_dump(exclude={"name"}) == scenario.model_dump(exclude={"name"})
    made = recipe(load_scenario(kept.scenario_document))
    assert made.command is not None
    words = shlex.split(made.command)
    assert words[:3] == ["motionlab", "run", "circle"]
    assert "variants.B.controller.x.k_p=210000.0" in words


def test_a_partial_live_run_with_events(kept: RunDetail) -> None:
    """A change, a push, a stop and a gap with their times."""
    path = "variants.B.controller.x.k_p"
    events = [
        Event(tick=400, kind="change", set={path: 3e5}, previous={path: 2e5}),
        Event(tick=600, kind="push", axis="y", force=-5.0, ticks=40),
        Event(tick=800, kind="gap", ticks=100, reason="the disk was full <b>"),
        Event(tick=1000, kind="stop"),
    ]
    update: dict[str, Any] = {"kind": "live", "state": "partial", "reason": "gap", "events": events}
    live = library().get(kept.id).model_copy(update=update | {"id": keep().id})
    library().index.put(live)
    page = Page(run_report(live.id))
    text = re.sub(r"\s+", " ", page.whole)
    for said in ("Partial run", "0.20000 s", "200 N/mm → 300 N/mm", "the disk was full <b>"):
        assert said in text, said
    assert "brakes to rest" in text
    marks = [line for line in page.plot("Following error x").iter(f"{SVG}line")]
    assert sum(line.get("class") == "mark" for line in marks) == len(events)


def test_a_measurement(tmp_path: Path) -> None:
    times = np.arange(2000) * 1e-3
    rows = [f"{t:.4f},{math.sin(6 * t):.6f},{math.sin(6 * t) - 0.002:.6f}" for t in times]
    rig = tmp_path / "rig.csv"
    rig.write_text("\n".join(["time [s],x_ref [mm],x_act [mm]", *rows]))
    _, measured = import_file(
        rig, ImportOptions("rig <7>", None, None, ()), library=library(), name=""
    )
    assert measured is not None
    page = Page(run_report(measured.id))
    assert "cannot be simulated again" in page.whole
    assert "gains of a measured machine are not known" in page.whole
    assert page.plot("Following error x") is not None


def test_a_comparison(kept: RunDetail) -> None:
    other = keep()
    how = Comparing.model_validate({"tolerance": {"absolute": 1e-6}, "only": ["*.following_error"]})
    page = Page(comparison_report(other.id, kept.id, how))
    assert "RMS on 4 of 4" in page.whole
    assert page.whole.index("Plots") < page.whole.index("Verdicts")
    assert "variants.B.controller.x.k_p" in page.whole
    check_nothing_is_loaded(page)
    with library().files.open(other.id) as a, library().files.open(kept.id) as b:
        name = "B.x.following_error"
        both = [file.read([name])[name].to_numpy() for file in (a, b)]
    low, high = min_max(np.stack([both[1] - both[0]]), 1)
    least, most = ends_of(page.plot(f"{name}: run 2 \u2212 run 1"), "two")
    scale = 1e9 if max(abs(low[0, 0]), high[0, 0]) < 1e-6 else 1e6
    assert least == pytest.approx(low[0, 0] * scale, abs=0.01 * abs(most - least))
    assert most == pytest.approx(high[0, 0] * scale, abs=0.01 * abs(most - least))


def test_many_variants_stay_within_the_size() -> None:
    """26 variants, whose plots draw fewer bins each."""
    controller = load_scenario("circle").model_dump(mode="json")["variants"]["B"]
    letters = [chr(ord("C") + i) for i in range(24)]
    many = keep({f"variants.{letter}": controller for letter in letters})
    page = Page(run_report(many.id))
    assert "more variants are not drawn" in page.whole
    assert "lines, which are not printed" in page.whole
    assert ("class", "long") in page.attributes


def test_a_run_of_one_tick_and_one_that_diverged(kept: RunDetail) -> None:
    moment = library().get(kept.id).model_copy(update={"id": keep().id, "ticks": 1})
    rewrite(moment, lambda table: table.slice(0, 1))
    library().index.put(moment)
    page = Page(run_report(moment.id))
    assert "1 sample of" in page.whole
    still = np.array([[0.015], [0.0]])
    picture = ElementTree.fromstring(str(plane(still, {"A": 0.0 * still}, {})))
    labels = [text.text or "" for text in picture.iter(f"{SVG}text")]
    assert max(map(len, labels)) <= len("\N{MINUS SIGN}14.995 mm")
    gone = Page(run_report(keep({"divergence_error": 1e-5}).id))
    assert "diverged at" in gone.whole
    check_nothing_is_loaded(gone)
    assert len(Page(comparison_report(moment.id, kept.id, Comparing(exact=True))).svgs) > 0


def test_refusals_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "a.html")
    assert main(["report", "r-aaaaaaaaaaaa", "--out", out]) == 2
    assert "RUN" in capsys.readouterr().err
    assert main(["report", "fig5", "--out", out]) == 2
    assert main(["report", "r-aaaaaaaaaaaa", "--out", str(tmp_path / "a.pdf")]) == 2
    assert not Path(out).exists()
