"""The wheel that the image installs, built from what backend/Dockerfile copies, and served."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import httpx
import pytest

from tests.e2e.conftest import Server, missing
from tests.project.dockerfile import ROOT, copy, stages
from tests.project.every_get import NO_DRIVE, UNDESCRIBED, look_at_everything
from tests.service.servers import PATIENCE

BUILD = next(stage for stage in stages() if stage.name == "build")


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that the wheel is built in, filled by every COPY."""
    dist = ROOT / "frontend" / "dist"
    if not (dist / "index.html").is_file():
        missing("the page is not built: frontend/npm run build")
    folder = tmp_path_factory.mktemp("image")
    built = folder / "page" / "src" / "frontend"
    built.mkdir(parents=True)
    (built / "dist").symlink_to(dist)
    for instruction, argument in BUILD.steps:
        if instruction == "COPY":
            copy(argument, folder, BUILD.last("WORKDIR"), {"page": folder / "page"})
    return folder / BUILD.last("WORKDIR").lstrip("/")


@pytest.fixture(scope="module")
def installed(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder into which the last RUN installs, beside this environment's packages."""
    pip, *arguments = BUILD.last("RUN").split()
    assert pip.endswith("/bin/pip")
    target = tmp_path_factory.mktemp("installed")
    command = [sys.executable, "-m", "pip", *arguments, "--quiet", "--target", str(target)]
    subprocess.run(command, cwd=source, check=True, timeout=PATIENCE)
    return target


def files(folder: Path) -> set[Path]:
    """Return the files below a folder that are no compiled Python."""
    found = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    return {path for path in found if path.suffix != ".pyc"}


def test_what_the_wheel_includes_is_there_to_be_included(source: Path) -> None:
    """A path that is missing is left out in silence."""
    tables = tomllib.loads((source / "pyproject.toml").read_text())
    wheel = tables["tool"]["hatch"]["build"]["targets"]["wheel"]
    for path in [*wheel["only-include"], *wheel["sources"]]:
        assert (source / path).exists(), path


def test_the_wheel_holds_every_file_that_is_copied(source: Path, installed: Path) -> None:
    package = files(installed / "motionlab")
    copied = files(source / "backend" / "motionlab")
    copied |= {Path("configs") / path for path in files(source / "configs")}
    assert copied == package
    assert {Path("page/index.html.gz"), Path("studies/paper/known_failures.toml")} <= package


def test_nothing_that_the_wheel_serves_fails(installed: Path, tmp_path: Path) -> None:
    variables = {"PYTHONPATH": str(installed), "NUMBA_DISABLE_JIT": "1"}
    server = Server(tmp_path, **variables)
    try:
        maps = Path(f"/proc/{server.pid}/environ").read_bytes()
        assert f"PYTHONPATH={installed}".encode() in maps
        with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:

            def ask(method: str, path: str, body: object = None) -> tuple[int, bytes]:
                answer = client.request(method, path, json=body)
                return answer.status_code, answer.content

            asked = look_at_everything(ask)
            described = client.get("/openapi.json").json()["paths"]
    finally:
        server.stop()
    readable = [
        path for path, each in described.items() if "get" in each and not path.startswith(NO_DRIVE)
    ]
    for path in [*UNDESCRIBED, *readable]:
        form = re.sub(r"\\\{\w+\\\}", "[^/]+", re.escape(path))
        assert any(re.fullmatch(form, found.partition("?")[0]) for found in asked), path
    assert any(path.endswith(".css") for path in asked)
