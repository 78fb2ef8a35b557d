"""The built page and JSON as they are sent: compressed, cached, and no more than that."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator

import httpx
import pytest

from motionlab.server.http.compression import SMALLEST
from motionlab.server.settings import Settings
from tests.server.live import API, Live
from tests.server.servers import PATIENCE, Server

TEXT = b"console.log('motion');" * 100
PLAIN = {"Accept-Encoding": "identity"}
GZIP = {"Accept-Encoding": "zstd, gzip;q=0.8"}
BROTLI = {"Accept-Encoding": "gzip, deflate, br"}
PACKED = b"the text, packed by Brotli, which Python does not know"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    """A server of a small page, its texts packed beforehand, those of assets nothing else."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "assets").mkdir()
    for name in ("index.html", "docs.html", "assets/index-AbCdEfGh.js", "favicon.svg"):
        if not name.startswith("assets"):
            (folder / name).write_bytes(TEXT)
        (folder / f"{name}.gz").write_bytes(gzip.compress(TEXT, mtime=0))
        (folder / f"{name}.br").write_bytes(PACKED)
    (folder / "assets" / "font-AbCdEfGh.woff2").write_bytes(TEXT)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("motionlab.server.http.page.page_root", lambda: folder)
        server = Server()
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        yield client
    server.stop()


def sent(client: httpx.Client, path: str, headers: dict[str, str]) -> tuple[httpx.Response, int]:
    """Return an answer to GET, and how many bytes its content takes on the wire."""
    answer = client.get(path, headers=headers)
    return answer, answer.num_bytes_downloaded


# -- the page -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "media"),
    [
        ("/", "text/html"),
        ("/docs", "text/html"),
        ("/favicon.svg", "image/svg+xml"),
        ("/assets/index-AbCdEfGh.js", "text/javascript"),
    ],
)
def test_a_text_is_sent_as_it_was_compressed(site: httpx.Client, path: str, media: str) -> None:
    packed, length = sent(site, path, GZIP)
    assert packed.headers["content-encoding"] == "gzip"
    assert length == int(packed.headers["content-length"]) < len(TEXT) / 4
    plain, length = sent(site, path, PLAIN)
    assert "content-encoding" not in plain.headers
    assert length == len(TEXT)
    for answer in (packed, plain):
        assert answer.status_code == 200
        assert answer.headers["vary"] == "Accept-Encoding"
        assert answer.headers["content-type"].split(";")[0] == media
    assert packed.headers["etag"] != plain.headers["etag"]
    assert site.get(path).content == TEXT
    head = site.head(path, headers=GZIP).headers
    assert head["content-length"] == packed.headers["content-length"]
    assert site.head(path, headers=PLAIN).content == b""


@pytest.mark.parametrize("path", ["/", "/assets/index-AbCdEfGh.js"])
@pytest.mark.parametrize(
    ("accepted", "coding"),
    [
        ("gzip, deflate, br, zstd", "br"),
        ("BR;q=0.1, gzip;q=1.0", "br"),
        ("br;q=0, gzip", "gzip"),
        ("br; q=0.000", None),
        ("brotli", None),
    ],
)
def test_brotli_goes_before_gzip(
    site: httpx.Client, path: str, accepted: str, coding: str | None
) -> None:
    with site.stream("GET", path, headers={"Accept-Encoding": accepted}) as answer:
        body = b"".join(answer.iter_raw())
    assert answer.headers.get("content-encoding") == coding
    assert body == {"br": PACKED, "gzip": gzip.compress(TEXT, mtime=0), None: TEXT}[coding]
    assert answer.headers["vary"] == "Accept-Encoding"


@pytest.mark.parametrize("path", ["/assets/none.js", "/assets/", "/assets", "/none.gz", "/none.br"])
def test_what_is_not_there_is_not_found(site: httpx.Client, path: str) -> None:
    assert site.get(path, headers=PLAIN).status_code == 404


@pytest.mark.parametrize(
    "accepted", ["identity", "", "gzip;q=0", "gzip; q=0.000", "zstd", "x-gzip-not"]
)
def test_who_does_not_accept_gzip_gets_none(site: httpx.Client, accepted: str) -> None:
    for path in ("/", "/openapi.json"):
        answer, _ = sent(site, path, {"Accept-Encoding": accepted})
        assert "content-encoding" not in answer.headers


def test_browsers_keep_what_never_changes_and_ask_again_for_the_rest(site: httpx.Client) -> None:
    for path in ("/", "/docs", "/favicon.svg"):
        assert site.get(path).headers["cache-control"] == "no-cache"
    for path in ("/assets/index-AbCdEfGh.js", "/assets/font-AbCdEfGh.woff2"):
        kept = site.get(path).headers["cache-control"]
        assert kept == "public, max-age=31536000, immutable"


@pytest.mark.parametrize("headers", [PLAIN, GZIP, BROTLI])
def test_what_the_browser_has_is_not_sent_again(
    site: httpx.Client, headers: dict[str, str]
) -> None:
    for path in ("/", "/docs", "/assets/index-AbCdEfGh.js"):
        tag = site.get(path, headers=headers).headers["etag"]
        again, length = sent(site, path, headers | {"If-None-Match": tag})
        assert (again.status_code, length) == (304, 0)
        assert again.headers["etag"] == tag
        assert again.headers["vary"] == "Accept-Encoding"
        assert "cache-control" in again.headers


def test_without_the_page_docs_says_how_to_build_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motionlab.server.http.page.page_root", lambda: None)
    server = Server()
    try:
        answer = httpx.get(f"{server.url}/docs", timeout=PATIENCE)
        assert answer.status_code == 404
        assert answer.json()["detail"].startswith("The page is not built: `make run`")
    finally:
        server.stop()


# -- the documentation ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def manual(tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    """A server with a token, and with documentation of two files."""
    folder = tmp_path_factory.mktemp("help")
    (folder / "index.html").write_bytes(TEXT)
    (folder / "lab.webp").write_bytes(TEXT)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("motionlab.server.http.page.help_root", lambda: folder)
        server = Server(Settings(token="a-token-of-some-length"))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        yield client
    server.stop()


def test_the_documentation_is_compressed_revalidated_and_needs_no_token(
    manual: httpx.Client,
) -> None:
    assert manual.get("/docs").status_code == 401
    moved = manual.get("/help")
    assert (moved.status_code, moved.headers["location"]) == (307, "/help/")
    packed, length = sent(manual, "/help/", GZIP)
    assert packed.headers["content-encoding"] == "gzip"
    assert length == int(packed.headers["content-length"]) < len(TEXT) / 4
    plain, length = sent(manual, "/help/", PLAIN)
    assert ("content-encoding" in plain.headers, length) == (False, len(TEXT))
    for answer in (packed, plain):
        assert answer.content == TEXT
        assert answer.headers["vary"] == "Accept-Encoding"
        assert answer.headers["cache-control"] == "no-cache"
        assert answer.headers["content-type"].startswith("text/html")
        assert "script-src 'self'" in answer.headers["content-security-policy"]
        known = {"If-None-Match": answer.headers["etag"]}
        assert manual.get("/help/index.html", headers=GZIP | known).status_code == 304
    picture = manual.get("/help/lab.webp", headers=GZIP)
    assert (picture.status_code, "content-encoding" in picture.headers) == (200, False)
    assert manual.get("/help/nothing.html").status_code == 404


def test_without_the_documentation_help_says_how_to_build_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("motionlab.server.http.page.help_root", lambda: None)
    server = Server()
    try:
        for path in ("/help", "/help/", "/help/lab.html"):
            answer = httpx.get(f"{server.url}{path}", timeout=PATIENCE)
            assert answer.status_code == 404
            assert "`make docs`" in answer.json()["detail"]
    finally:
        server.stop()


# -- JSON -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", ["/openapi.json", f"{API}/paper", f"{API}/scenarios/circle"])
def test_json_is_compressed(client: httpx.Client, path: str) -> None:
    packed, length = sent(client, path, GZIP)
    assert packed.headers["content-encoding"] == "gzip"
    assert length == int(packed.headers["content-length"])
    plain, whole = sent(client, path, PLAIN)
    assert "content-encoding" not in plain.headers
    assert whole > SMALLEST
    assert length < whole / 2
    for answer in (packed, plain):
        assert answer.headers["vary"] == "Accept-Encoding"
    assert client.get(path, headers=GZIP).json() == client.get(path, headers=PLAIN).json()
    head = client.head(path, headers=GZIP).headers
    assert head["content-encoding"] == "gzip"


def test_a_problem_is_compressed_too(client: httpx.Client) -> None:
    wrong = {f"plant.x.mass_{i}": 1 for i in range(100)}
    answer = client.post(f"{API}/simulate", json={"set": wrong}, headers=GZIP)
    assert (answer.status_code, answer.headers["content-encoding"]) == (422, "gzip")
    assert answer.json()["status"] == 422


def test_nothing_else_is_compressed(client: httpx.Client, live: Live) -> None:
    live.step(2000)
    paths = [
        f"{API}/health",  # JSON, but small
        "/metrics",
        *(f"{live.path}/telemetry?format={form}" for form in ("csv", "parquet")),
    ]
    for path in paths:
        answer, _ = sent(client, path, GZIP)
        assert answer.status_code == 200
        assert "content-encoding" not in answer.headers, path
    answer = client.post(f"{API}/whatif", json={"points": 500}, headers=GZIP)
    assert (answer.status_code, "content-encoding" in answer.headers) == (200, False)
    assert json.loads(client.get(f"{API}/health").text)["status"] == "ok"
