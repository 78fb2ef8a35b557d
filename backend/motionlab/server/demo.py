"""The lab as a static folder: the built page, and files in place of the server's answers."""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import json
import math
import typing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fastapi import FastAPI
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import bounds_of, members
from motionlab.errors import MotionLabError
from motionlab.server.app import PREFIX, create_app
from motionlab.server.http.page import page_root
from motionlab.server.settings import Settings
from motionlab.simulation.lane_run import Known, lane_run
from motionlab.simulation.prepare import prepare
from motionlab.simulation.whatif import Extent, beginning
from motionlab.studies.why.causes import causes_table
from motionlab.studies.why.explain import GOAL, REACH
from motionlab.targets.motion_code import motion_code
from motionlab.telemetry.channels import stream_columns

_LEFT_OUT = ("docs.html", "docs-", "swagger")
"""Files of the page whose names begin so: the API's own page."""
_MANIFEST = "motionlab-demo.json"
"""Names of the files of a demo: a later one removes these, and nothing else."""
_OF_HOST = "CNAME"
"""What a static host keeps beside the files, but for names that begin with a dot."""
_BITS = 40
"""Inputs are rounded to 2^-40 of the largest of their row: of 15 mm, to 1e-14 m."""
_ORDER_MAX = 5
_PLANES = 6
"""Bytes of a rounded input: 40 bits, and those that differences of order 5 add."""

_WORKER = """\
// Keeps the files of this demo, so that it opens without a network.
// The host has a cache for all demos on it: the name has the address of this one.
const OWN = `motionlab ${{registration.scope}} `;
const NAME = `${{OWN}}{name}`;
// Not from the browser's own cache, which may have files of an older demo.
const FILES = {files}.map((file) => new Request(file, {{ cache: 'reload' }}));
const PAGE = new URL('./', registration.scope).href;
addEventListener('install', (event) => {{
  event.waitUntil(caches.open(NAME).then((cache) => cache.addAll(FILES)));
}});
addEventListener('activate', (event) => {{
  const old = (name) => name.startsWith(OWN) && name !== NAME;
  const remove = (names) => Promise.all(names.filter(old).map((name) => caches.delete(name)));
  event.waitUntil(caches.keys().then(remove));
}});
const kept = async (file) => {{
  const cache = await caches.open(NAME);
  return cache.match(file, {{ ignoreSearch: true }});
}};
// Another program may have this address now, such as a lab on the same port: the demo gives way.
const giveWay = async () => {{
  await registration.unregister();
  const own = (await caches.keys()).filter((name) => name.startsWith(OWN));
  await Promise.all(own.map((name) => caches.delete(name)));
}};
const page = async (request) => {{
  let answer;
  try {{
    answer = await fetch(request);
  }} catch {{
    return (await kept(PAGE)) ?? Response.error();
  }}
  if ((await answer.clone().text()).includes('motionlab-demo')) return (await kept(PAGE)) ?? answer;
  await giveWay();
  return answer;
}};
addEventListener('fetch', (event) => {{
  const {{ request }} = event;
  if (request.mode === 'navigate') event.respondWith(page(request));
  else event.respondWith(kept(request).then((file) => file ?? fetch(request)));
}});
"""


def write_demo(folder: Path) -> list[Path]:
    """Write the lab as files that any static host serves, from any path.

    Files of an older demo are removed, others stay: `_files_of_demo` refuses them.

    Raises
    ------
    MotionLabError
        If the page is not built, or the folder holds something else.
    """
    root = page_root()
    if root is None:
        raise MotionLabError("the page is not built: `make run` in a checkout builds it")
    folder = folder.resolve()
    _files_of_demo(folder)  # refused before all is computed
    data = _data_files()
    # A page and data of two versions never meet: the page names the folder by its content.
    place = f"data-{_digest(data)}/"
    files = {**_page_files(root), **{place + name: content for name, content in data.items()}}
    files["index.html"] = _marked(files["index.html"], place)
    files["sw.js"] = _service_worker(files)
    _replace(folder, files)
    return [folder / name for name in files]


def _replace(folder: Path, files: dict[str, bytes]) -> None:
    """Write a demo in place of an older one, of which no file stays."""
    for name in _files_of_demo(folder):
        path = folder / name
        path.unlink()
        for parent in path.relative_to(folder).parents[:-1]:
            if not any((folder / parent).iterdir()):
                (folder / parent).rmdir()
    # The manifest comes first: what an interruption leaves is a demo, too.
    manifest = json.dumps(sorted([*files, _MANIFEST]), indent=1).encode()
    for name, content in {_MANIFEST: manifest, **files}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def _files_of_demo(folder: Path) -> list[str]:
    """Return the files that an older demo wrote, its manifest last.

    Raises
    ------
    MotionLabError
        If there is a file of something else, but for those of version control and host.
    """
    if not folder.exists():
        return []
    if not folder.is_dir():
        raise MotionLabError(f"{folder} is no folder: name another one")
    manifest = folder / _MANIFEST
    written = set(json.loads(manifest.read_bytes())) if manifest.is_file() else set()
    entries = [each for each in folder.iterdir() if each.name[0] != "." and each.name != _OF_HOST]
    paths = [each for entry in entries for each in (entry, *entry.rglob("*"))]
    names = [
        path.relative_to(folder).as_posix()
        for path in paths
        if path.is_symlink() or not path.is_dir()
    ]
    others = sorted(set(names) - written)
    if others:
        raise MotionLabError(
            f"{folder} is not empty, and {others[0]} is of no demo: name another folder"
        )
    return sorted(names, key=lambda name: name == _MANIFEST)


def _page_files(root: Path) -> dict[str, bytes]:
    """Return the files of the built page, not compressed, but for the API's own page."""
    files = {}
    for path in sorted(each for each in root.rglob("*") if each.is_file()):
        name = path.relative_to(root).as_posix().removesuffix(".gz")
        if path.suffix != ".br" and not path.name.startswith(_LEFT_OUT):
            content = path.read_bytes()
            files[name] = gzip.decompress(content) if path.suffix == ".gz" else content
    return files


def _data_files() -> dict[str, bytes]:
    files = {"answers.bin": _zipped(json.dumps(_answers()).encode())}
    for name in names("scenarios"):
        files[f"{name}.bin"] = _zipped(_lanes(name))
    files["motions.js"] = motion_code().encode()
    return files


def _answers() -> dict[str, Any]:
    """Return the server's answers to requests that need nothing but what ships, by path."""
    paths = ["/scenarios", "/fields", "/fields/tune", "/fields/why", "/parts"]
    paths += ["/trajectories"]
    paths += [f"/{kind}/{name}" for kind in ("scenarios", "trajectories") for name in names(kind)]
    answers = asyncio.run(_of_server(paths))
    motors = answers["/parts"]["motors"]
    answers["/parts"]["motors"] = [each for each in motors if each["name"] in names("motors")]
    answers["/trajectories"] = [each for each in answers["/trajectories"] if each["shipped"]]
    return {
        **answers,
        "/health": {
            "login": False,
            "drive": None,
            "help": False,
            "compiling": False,
            "compiled_share": 1.0,
        },
        "/gain-sets": [],
        "/layouts": [],
        "/maps": [],
        "plants": {
            name: load_scenario({"base": "circle", "plant": name}).plant.model_dump(mode="json")
            for name in names("motors")
        },
        "why": {"reach": REACH, "goal": GOAL, "causes": causes_table()},
        # By kind: /fields has one of each name, without bounds where kinds differ.
        "bounds": {
            typing.get_args(motion.model_fields["kind"].annotation)[0]: {
                name: ends
                for name, field in motion.model_fields.items()
                if (ends := bounds_of(field))
            }
            for motion in members(Scenario.model_fields["trajectory"].annotation)
        },
        # Of all scenarios that ship, which have two variants; a session's stream would name them.
        "channels": [
            {"name": name, "unit": channel.unit, "meaning": channel.meaning}
            for name, channel in stream_columns("AB")
        ],
    }


async def _of_server(paths: list[str]) -> dict[str, Any]:
    """Ask an application in this process, without its workers."""
    app = create_app(Settings())
    return {path: await _get(app, PREFIX + path) for path in paths}


async def _get(app: FastAPI, path: str) -> Any:
    """Return what a path answers, without a network."""
    sent: list[dict[str, Any]] = []

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Any) -> None:
        sent.append(message)

    scope = {
        "type": "http",
        "http_version": "1.1",
        "method": "GET",
        "scheme": "http",
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "headers": [(b"host", b"127.0.0.1")],
        "client": ("127.0.0.1", 1),
        "server": ("127.0.0.1", 80),
    }
    await app(scope, receive, send)
    status = next(each["status"] for each in sent if "status" in each)
    body = b"".join(each.get("body", b"") for each in sent)
    if status != 200:
        raise MotionLabError(f"GET {path} answers {status}: {body.decode()}")
    return json.loads(body)


# -- lanes and inputs -----------------------------------------------------------------------------


def _lanes(name: str) -> bytes:
    """Return the answer to POST /whatif/lanes, its inputs packed behind it.

    Raises
    ------
    Obstacle
        If the page cannot run the scenario.
    """
    prepared = prepare(load_scenario(name))
    start, stop = beginning(prepared, name, {}, Extent(False, Settings().direct_work_max))
    run = lane_run(prepared, start, stop, Known())
    rows = [_packed_row(row) for row in run.inputs] if run.inputs is not None else []
    planes = b"".join(planes.tobytes() for _, _, planes in rows)
    head = [{"exponent": exponent, "order": order} for exponent, order, _ in rows]
    answer = replace(run, inputs=None).packed(packed=head)
    return answer + bytes(-len(planes) % 8) + planes


def _packed_row(row: NDArray[np.float64]) -> tuple[int, int, NDArray[np.uint8]]:
    """Return a row as whole multiples of 2^exponent: differences of an order, byte by byte."""
    exponent = math.frexp(float(np.abs(row).max()))[1] - _BITS
    whole = np.rint(np.ldexp(row, -exponent)).astype(np.int64)
    order, least = min(
        (
            (order, np.diff(whole, n=order, prepend=[0] * order) if order else whole)
            for order in range(_ORDER_MAX)
        ),
        key=lambda each: float(np.log2(1.0 + np.abs(each[1])).sum()),
    )
    folded = np.where(least < 0, -2 * least - 1, 2 * least).astype("<u8")
    return exponent, order, folded.view(np.uint8).reshape(-1, 8)[:, :_PLANES].T


def _zipped(content: bytes) -> bytes:
    return gzip.compress(content, 9, mtime=0)


# -- the page -------------------------------------------------------------------------------------


def _marked(page: bytes, data: str) -> bytes:
    """Return the page with the mark by which its scripts take answers from files."""
    mark = f'<meta name="motionlab-demo" content="{data}" />'.encode()
    return page.replace(b"</title>", b"</title>\n    " + mark, 1)


def _service_worker(files: dict[str, bytes]) -> bytes:
    """Return the script with which the lab opens again without a network."""
    kept = [name for name in files if name != "index.html" and not name.startswith("licenses/")]
    return _WORKER.format(name=_digest(files), files=json.dumps(["./", *kept])).encode()


def _digest(files: dict[str, bytes]) -> str:
    digest = hashlib.sha256()
    for name, content in files.items():
        digest.update(name.encode() + content)
    return digest.hexdigest()[:16]
