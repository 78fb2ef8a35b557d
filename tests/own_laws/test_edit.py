"""``motionlab serve --edit-laws``: a law's file written over REST, and what is refused."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.own_laws.template import template
from tests.library.served import API
from tests.own_laws.test_everywhere import command
from tests.own_laws.test_live import until
from tests.own_laws.with_laws import serving

MINE = template("mine")
HALF = MINE.replace("seen.friction.F_c", "0.5 * seen.friction.F_c")
TOKEN = "0123456789abcdef-edit"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("edited") / "laws"
    folder.mkdir()
    (folder / "mine.py").write_text(MINE)
    other = tmp_path_factory.mktemp("elsewhere") / "linked.py"
    other.write_text(template("linked"))
    (folder / "linked.py").symlink_to(other)
    return folder


@pytest.fixture(scope="module")
def client(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    data = tmp_path_factory.mktemp("data")
    with serving(folder, data, "--edit-laws", token=TOKEN) as client:
        yield client


@pytest.fixture(autouse=True)
def as_before(folder: Path) -> Iterator[None]:
    """Give each test the file as it was first."""
    yield
    (folder / "mine.py").write_text(MINE)


def digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def entry(client: httpx.Client, name: str = "mine") -> dict[str, Any]:
    laws = client.get(f"{API}/laws").raise_for_status().json()["laws"]
    return next(law for law in laws if law["name"] == name)


def put(
    client: httpx.Client, text: str, known: str = MINE, name: str = "mine", **headers: str
) -> httpx.Response:
    return client.put(
        f"{API}/laws/{name}", json={"text": text}, headers={"If-Match": digest(known)} | headers
    )


def test_what_is_written_is_in_the_file_and_runs(client: httpx.Client, folder: Path) -> None:
    assert entry(client)["digest"] == digest(MINE)
    mode = (folder / "mine.py").stat().st_mode
    answer = put(client, HALF)
    assert answer.status_code == 200, answer.text
    assert answer.json()["digest"] == digest(HALF)
    assert (folder / "mine.py").read_text() == HALF
    assert (folder / "mine.py").stat().st_mode == mode
    until(lambda: entry(client)["text"] == HALF and entry(client)["version"] > 1)
    wrong = put(client, HALF + "1 +\n", HALF)
    assert wrong.status_code == 200
    until(lambda: "mine.py:16: mine: SyntaxError" in entry(client)["problem"])


def test_a_file_that_has_changed_meanwhile_is_not_overwritten(
    client: httpx.Client, folder: Path
) -> None:
    other = MINE + "# by an editor\n"
    (folder / "mine.py").write_text(other)
    answer = put(client, HALF)
    assert answer.status_code == 409
    assert "mine.py was changed on the disk" in answer.json()["detail"]
    assert (folder / "mine.py").read_text() == other
    (folder / "mine.py").unlink()
    assert put(client, HALF).status_code == 507 or not (folder / "mine.py").exists()


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Authorization": ""}, 401),
        ({"Authorization": "Bearer 0123456789abcdef-edi"}, 401),
        ({"Cookie": "motionlab_80=x.99999999999.y", "Authorization": ""}, 401),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Host": "evil.example"}, 403),
        ({"Sec-Fetch-Site": "cross-site"}, 403),
        ({"Content-Type": "text/plain"}, 415),
        ({"If-Match": "*"}, 409),
        ({"If-Match": "x" * 81}, 422),
    ],
    ids=str,
)
def test_others_are_refused(
    client: httpx.Client, folder: Path, headers: dict[str, str], status: int
) -> None:
    answer = put(client, HALF, **headers)
    assert answer.status_code == status, answer.text
    assert (folder / "mine.py").read_text() == MINE


@pytest.mark.parametrize(
    "name",
    [
        *("residual-k", "mine@before", "nobody", "mine.py", "..%2Fmine", "..%2F..%2Fetc%2Fpasswd"),
        *("..", "%2e%2e", "mine%00", "/etc/passwd", "x" * 200),
    ],
)
def test_only_files_of_the_folders_are_written(
    client: httpx.Client, folder: Path, name: str
) -> None:
    before = sorted(folder.parent.rglob("*"))
    assert put(client, HALF, name=name).status_code in {404, 405, 422}
    assert sorted(folder.parent.rglob("*")) == before


def test_a_link_is_not_followed(client: httpx.Client, folder: Path) -> None:
    text = template("linked")
    answer = put(client, text + "# more\n", text, name="linked")
    assert answer.status_code == 409
    assert (folder / "linked.py").is_symlink()
    assert (folder / "linked.py").read_text() == text


@pytest.mark.parametrize(
    ("text", "status"),
    [
        ("#" * (256 * 1024 + 1), 422),
        ("é" * (128 * 1024 + 1), 422),
        ("#" * 2_000_000, 413),
    ],
    ids=["characters", "bytes", "body"],
)
def test_a_text_that_is_too_large_is_refused(
    client: httpx.Client, folder: Path, text: str, status: int
) -> None:
    assert put(client, text).status_code == status
    assert (folder / "mine.py").read_text() == MINE


def test_half_of_a_character_is_refused(client: httpx.Client, folder: Path) -> None:
    headers = {"If-Match": digest(MINE), "Content-Type": "application/json"}
    answer = client.put(f"{API}/laws/mine", content=b'{"text": "\\ud800"}', headers=headers)
    assert answer.status_code in {400, 422}, answer.text
    assert (folder / "mine.py").read_text() == MINE


def test_of_two_at_once_one_is_taken(client: httpx.Client, folder: Path) -> None:
    texts = [MINE + f"# {k}\n" for k in range(2)]
    assert [put(client, text).status_code for text in texts] == [200, 409]
    assert (folder / "mine.py").read_text() == texts[0]


def test_without_the_option_it_is_refused_with_the_reason(folder: Path, tmp_path: Path) -> None:
    with serving(folder, tmp_path, token=TOKEN) as client:
        answer = put(client, HALF)
        assert answer.status_code == 403
        assert "motionlab serve --edit-laws permits it" in answer.json()["detail"]
        assert entry(client)["digest"] == ""
    assert (folder / "mine.py").read_text() == MINE


@pytest.mark.parametrize(
    ("options", "variables", "reason"),
    [
        ((), {}, "needs a token"),
        (("--host", "0.0.0.0"), {"MOTIONLAB_TOKEN": TOKEN}, "on loopback only, not on 0.0.0.0"),
        (("--name", "lab.example.org"), {"MOTIONLAB_TOKEN": TOKEN}, "further names or proxies"),
        ((), {"MOTIONLAB_TOKEN": TOKEN, "MOTIONLAB_PROXIES": "127.0.0.1"}, "names or proxies"),
    ],
    ids=["token", "host", "name", "proxy"],
)
def test_a_server_that_others_reach_does_not_start(
    folder: Path, options: tuple[str, ...], variables: dict[str, str], reason: str
) -> None:
    done = command("serve", "--port", "0", "--edit-laws", "--laws", folder, *options, **variables)
    assert done.returncode == 2
    assert "--edit-laws" in done.stderr and reason in done.stderr


def test_the_variable_is_the_option(folder: Path) -> None:
    done = command("serve", "--port", "0", "--laws", folder, MOTIONLAB_EDIT_LAWS="true")
    assert done.returncode == 2
    assert "MOTIONLAB_EDIT_LAWS" in done.stderr and "needs a token" in done.stderr
