"""Plots as pictures and numbers."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from xml.etree import ElementTree

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.actions import LONG, region, simulated
from tests.e2e.conftest import Server

SVG = "{http://www.w3.org/2000/svg}"


def saved(page: Page, choice: str, folder: Path) -> Path:
    with page.expect_download() as caught:
        page.get_by_role("menuitem", name=choice).click()
    file = folder / caught.value.suggested_filename
    caught.value.save_as(file)
    return file


def test_a_scope_is_saved_as_png_svg_and_csv(page: Page, server: Server, tmp_path: Path) -> None:
    page.keyboard.press("w")
    scope = page.get_by_role("region", name=re.compile("Following error x"))
    canvas = scope.locator("canvas")
    first, _ = simulated(page, server)
    expect(region(page, "Metrics")).to_contain_text(first, timeout=LONG)
    box = canvas.bounding_box()
    assert box is not None

    canvas.click(button="right")
    drawing = ElementTree.parse(saved(page, "Save as SVG", tmp_path)).getroot()
    assert drawing.findtext(f"{SVG}title") == "Following error x"
    texts = ["".join(text.itertext()) for text in drawing.iter(f"{SVG}text")]
    assert {"A", "Following error x"} <= set(texts)
    assert any(re.fullmatch(r"B axis ±[\d.]+\W+µm", text) for text in texts), texts
    assert any(text.endswith("µm") for text in texts)
    curves = [path for path in drawing.iter(f"{SVG}path") if len(path.get("d") or "") > 1000]
    assert [curve.get("stroke") for curve in curves][:2] == ["#d55e00", "#0072b2"]
    places = [float(y) for y in re.findall(r"[ML]\S+ ([\d.-]+)", curves[0].get("d") or "")]
    assert max(places) - min(places) > 0.5 * (box["height"] - 30)

    scope.get_by_role("button", name="Save or copy the plot").press("Enter")
    content = saved(page, "Save as PNG", tmp_path).read_bytes()
    assert content.startswith(b"\x89PNG")
    width, height = struct.unpack_from(">II", content, 16)
    assert (width, height) == (
        2 * int(drawing.get("width") or 0),
        2 * int(drawing.get("height") or 0),
    )

    canvas.click(button="right")
    head, *rows = saved(page, "Save numbers as CSV", tmp_path).read_text().splitlines()
    names = head.split(",")
    assert names[0] == "time [s]"
    assert all(name.endswith("[m]") for name in names[1:])
    times = [float(row.split(",")[0]) for row in rows]
    step = times[1] - times[0]
    assert len(times) == pytest.approx((times[-1] - times[0]) / step + 1)
    least = min(float(row.split(",")[1]) for row in rows)
    assert -30e-6 < least < -15e-6

    region(page, "Scopes").get_by_role("button", name="Table").click()
    with page.expect_download() as caught:
        region(page, "Scopes").get_by_role("button", name="CSV").click()
    table = Path(caught.value.path()).read_text().splitlines()
    assert "time [s]" in table[0]
    assert len(table) == 1 + region(page, "Scopes").locator("tbody tr").count()
