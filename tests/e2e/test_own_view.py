"""A view and a study of one's own on the page: in the list of views, and among the jobs."""

from __future__ import annotations

from collections.abc import Iterator

import httpx
import pytest
from playwright.sync_api import Page, expect

from tests.e2e.actions import LONG, region, serious
from tests.e2e.conftest import Server, missing
from tests.paths import ROOT
from tests.project.test_extending import EXAMPLES


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    if not (ROOT / "frontend" / "dist" / "index.html").is_file():
        missing("the page is not built: make frontend/dist/index.html")
    folder = tmp_path_factory.mktemp("files")
    (folder / "studies").mkdir()
    for each in EXAMPLES:
        if each.file.startswith("studies/"):
            (folder / each.file).write_text(each.text)
    server = Server(tmp_path_factory.mktemp("data"), "--studies", str(folder / "studies"))
    yield server
    server.stop()


@pytest.mark.usefixtures("fresh")
def test_an_own_view_is_in_the_list_and_shows_its_numbers(page: Page, server: Server) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.goto(f"{server.url}/?screen=views")
    page.get_by_role("radio", name="Error budget").or_(
        page.get_by_role("button", name="Error budget")
    ).first.click()
    table = page.get_by_role("table", name="error budget")
    row = table.get_by_role("row", name="per sign")
    expect(row).to_contain_text("15.3", timeout=LONG)
    expect(row).to_contain_text("µm")
    expect(table.get_by_role("columnheader", name="B y")).to_be_visible()
    assert "pane=own" in page.url
    assert serious(page) == []

    page.get_by_role("button", name="Jobs").first.click()
    body = {"field": "variants.B.controller.x.k_p"}
    httpx.post(f"{server.url}/api/v1/studies/elasticity", json=body).raise_for_status()
    job = page.get_by_role("dialog", name="Jobs").get_by_role("listitem", name="elasticity")
    expect(job.get_by_role("link", name="JSON")).to_be_visible(timeout=LONG)
