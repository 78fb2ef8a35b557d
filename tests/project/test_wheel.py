"""The wheel, built from a checkout, from the sdist and in the image, installed and served."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import httpx
import pytest

from tests.e2e.conftest import Server, missing
from tests.project.dockerfile import ROOT, copy, stages
from tests.project.every_get import NO_DRIVE, UNDESCRIBED, look_at_everything
from tests.server.servers import PATIENCE

BUILD = next(stage for stage in stages() if stage.name == "build")
DIST = ROOT / "frontend" / "dist"


def hatch(folder: Path, *arguments: str, path: str = "") -> subprocess.CompletedProcess[str]:
    """Run the build backend in a folder, without node, git or any other program."""
    command = [sys.executable, "-m", "hatchling", *arguments]
    environment = {**os.environ, "PATH": path, "NO_COLOR": "1"}
    return subprocess.run(
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


def built(folder: Path, target: str) -> Path:
    """Return the wheel or the sdist of a folder."""
    out = folder.parent / f"{folder.name}-{target}"
    done = hatch(folder, "build", "-t", target, "-d", str(out))
    assert done.returncode == 0, done.stdout + done.stderr
    (file,) = out.iterdir()
    return file


def contents(wheel: Path) -> dict[str, bytes]:
    """Return the files of a wheel."""
    with zipfile.ZipFile(wheel) as file:
        return {name: file.read(name) for name in file.namelist()}


def files(folder: Path) -> set[str]:
    """Return the files below a folder that are no compiled Python."""
    found = {path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    return {path.relative_to(folder).as_posix() for path in found}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the checkout without git, the page in it built, of the help a page."""
    if not (DIST / "index.html").is_file():
        missing("the page is not built: make frontend/dist/index.html")
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if listed.returncode != 0:
        pytest.skip("no git checkout")
    folder = tmp_path_factory.mktemp("build") / "checkout"
    for name in listed.stdout.splitlines():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).is_file():
            shutil.copy(ROOT / name, folder / name)
    shutil.copytree(DIST, folder / "frontend" / "dist", copy_function=shutil.copy)
    (folder / "build" / "help").mkdir(parents=True)
    (folder / "build" / "help" / "index.html").write_text("as `make docs` builds it")
    return folder


@pytest.fixture(scope="module")
def wheel(checkout: Path) -> Path:
    """Return the wheel of the checkout."""
    return built(checkout, "wheel")


def test_the_wheel_holds_all_that_it_is_made_of(checkout: Path, wheel: Path) -> None:
    """What a pattern of pyproject.toml does not find is left out in silence."""
    package = files(checkout / "backend" / "motionlab")
    parts = {"configs": "configs", "page": "frontend/dist", "help": "build/help"}
    for target, folder in parts.items():
        package |= {f"{target}/{name}" for name in files(checkout / folder)}
    held = {name for name in contents(wheel) if ".dist-info/" not in name}
    assert held == {f"motionlab/{name}" for name in package}
    assert {"motionlab/py.typed", "motionlab/_version.py", "motionlab/page/index.html"} < held
    modules = re.findall(r"/page/assets/kernel-[^/]+\.wasm\.(.*)", "\n".join(held))
    assert sorted(modules) == ["br", "gz"]


def test_the_wheel_holds_the_licences_of_all_that_is_in_it(wheel: Path) -> None:
    held = contents(wheel)
    (metadata,) = (text for name, text in held.items() if name.endswith(".dist-info/METADATA"))
    assert b"License-Expression: MIT AND Apache-2.0 AND BSD-2-Clause" in metadata
    texts = {
        ".dist-info/licenses/LICENSE": b"MIT License",
        "fmi3/license.txt": b"2-Clause BSD License",
        ".dist-info/licenses/backend/motionlab/exchange/paths/rowmans.txt": b"Hershey",
        "page/licenses/svelte/LICENSE.md": b"Svelte Contributors",
        "page/licenses/swagger-ui-dist/LICENSE": b"Apache License",
    }
    for ending, words in texts.items():
        assert any(words in held[name] for name in held if name.endswith(ending)), ending


def test_the_sdist_builds_the_same_wheel_without_node(checkout: Path, wheel: Path) -> None:
    sdist = built(checkout, "sdist")
    with tarfile.open(sdist) as file:
        # Python 3.11.2, which Debian 12 was released with, knows no filters yet.
        if hasattr(tarfile, "data_filter"):
            file.extraction_filter = tarfile.data_filter
        file.extractall(checkout.parent)
    unpacked = checkout.parent / sdist.name.removesuffix(".tar.gz")
    for folder in ("tests", "docs", "CHANGELOG.md", "CITATION.cff", "README.md", "LICENSE"):
        assert (unpacked / folder).exists(), folder
    assert contents(built(unpacked, "wheel")) == contents(wheel)


def test_the_image_builds_the_same_wheel_without_the_help(wheel: Path, tmp_path: Path) -> None:
    page = tmp_path / "page" / "src" / "frontend"
    page.mkdir(parents=True)
    (page / "dist").symlink_to(DIST)
    (tmp_path / "packages" / "opt" / "motionlab").mkdir(parents=True)
    for instruction, argument in BUILD.steps:
        if instruction == "COPY":
            others = {"page": tmp_path / "page", "packages": tmp_path / "packages"}
            copy(argument, tmp_path, BUILD.last("WORKDIR"), others)
    held = contents(built(tmp_path / BUILD.last("WORKDIR").lstrip("/"), "wheel"))
    whole = contents(wheel)
    record = next(name for name in whole if name.endswith("/RECORD"))
    helps = {name for name in whole if name.startswith("motionlab/help/")}
    assert held.keys() == whole.keys() - helps
    assert {name: held[name] for name in held if name != record} == {
        name: whole[name] for name in held if name != record
    }


def test_a_wheel_without_its_documentation_is_not_built(checkout: Path, tmp_path: Path) -> None:
    """Its page would link to what is not there."""
    names = (
        "backend",
        "configs",
        "frontend",
        "docs",
        "pyproject.toml",
        "hatch_build.py",
        "LICENSE",
    )
    for name in names:
        (tmp_path / name).symlink_to(checkout / name)
    done = hatch(tmp_path, "build", "-t", "wheel", "-d", str(tmp_path / "out"))
    assert done.returncode == 1
    assert "motionlab: no help: make: " in done.stderr
    assert not list(tmp_path.glob("out/*.whl"))


@pytest.mark.parametrize("state", ["missing", "older"])
def test_a_page_that_cannot_be_built_ends_the_build_with_a_line(
    checkout: Path, tmp_path: Path, state: str
) -> None:
    for name in ("backend", "configs", "frontend", "pyproject.toml", "hatch_build.py", "LICENSE"):
        if state == "older" or name != "frontend":
            (tmp_path / name).symlink_to(checkout / name)
    if state == "older":
        os.utime(checkout / "frontend" / "dist" / "index.html", (0, 0))
    try:
        done = hatch(tmp_path, "build", "-t", "wheel", "-d", str(tmp_path / "out"))
    finally:
        (checkout / "frontend" / "dist" / "index.html").touch()
    assert done.returncode == 1
    (line,) = [line for line in done.stderr.splitlines() if "no page" in line]
    assert re.fullmatch(
        r"motionlab: no page: make: .*; see what `make frontend/dist/index.html` says", line
    )
    assert "Traceback" not in done.stderr + done.stdout
    assert not [*tmp_path.glob("out/*.whl")]


def test_the_version_counts_commits_and_needs_neither_tag_nor_git(
    checkout: Path, tmp_path: Path
) -> None:
    for name in ("pyproject.toml", "hatch_build.py", "LICENSE"):
        shutil.copy(checkout / name, tmp_path)
    assert hatch(tmp_path, "version").stdout == "0.1.0.dev0\n"
    git = ["git", "-c", "user.name=nobody", "-c", "user.email=", "-c", "init.defaultBranch=main"]
    for arguments in (["init"], ["add", "."], ["commit", "--message", "all"]):
        subprocess.run([*git, *arguments], cwd=tmp_path, check=True, capture_output=True)
    counted = hatch(tmp_path, "version", path=os.environ["PATH"]).stdout
    assert re.fullmatch(r"0\.1\.0\.dev1\+g[0-9a-f]{7,}\n", counted)
    assert hatch(tmp_path, "version").stdout == "0.1.0.dev0\n"


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the interpreter of an environment with the wheel and this one's other packages.

    A path in a file .pth is searched for packages, not for files .pth; so the checkout, which is
    installed here by such a file, is not found there.
    """
    environment = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    interpreter = environment / "bin" / "python"
    (site,) = environment.glob("lib/python*/site-packages")
    (site / "others.pth").write_text(sysconfig.get_path("purelib"))
    pip = [sys.executable, "-m", "pip", "--python", str(interpreter), "--quiet", "install"]
    options = ["--no-deps", "--no-compile", "--ignore-installed", "--disable-pip-version-check"]
    subprocess.run([*pip, *options, str(wheel)], check=True, timeout=PATIENCE)
    return interpreter


def test_nothing_that_the_wheel_serves_fails(python: Path, tmp_path: Path) -> None:
    code = "import motionlab; print(motionlab.__file__, motionlab.__version__)"
    file, version = subprocess.check_output([python, "-c", code], cwd=tmp_path, text=True).split()
    assert Path(file).is_relative_to(python.parents[1])
    assert version == "0.1.0.dev0"
    server = Server(tmp_path, python=str(python), NUMBA_DISABLE_JIT="1")
    try:
        with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:

            def ask(method: str, path: str, body: object = None) -> tuple[int, bytes]:
                answer = client.request(method, path, json=body)
                return answer.status_code, answer.content

            asked = look_at_everything(ask)
            described = client.get("/openapi.json").json()
    finally:
        server.stop()
    assert described["info"]["version"] == version
    readable = [
        path
        for path, each in described["paths"].items()
        if "get" in each and not path.startswith(NO_DRIVE)
    ]
    for path in [*UNDESCRIBED, *readable]:
        form = re.sub(r"\\\{\w+\\\}", "[^/]+", re.escape(path))
        assert any(re.fullmatch(form, found.partition("?")[0]) for found in asked), path
    assert any(path.endswith(".css") for path in asked)
