"""The application: routes, guard, problems, and documentation that works offline."""

from __future__ import annotations

import asyncio
import logging
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Any

from anyio.to_thread import current_default_thread_limiter
from fastapi import APIRouter, FastAPI
from fastapi.responses import PlainTextResponse
from prometheus_client import CONTENT_TYPE_LATEST

from motionlab import __version__
from motionlab.config.named_configs import data_root
from motionlab.library.job_records import RecordStore
from motionlab.server.garbage_collection import GarbageCollection
from motionlab.server.http import openapi, page, problems
from motionlab.server.http.access_log import AccessLog
from motionlab.server.http.compression import CompressedJson
from motionlab.server.http.connection_limits import ConnectionLimits
from motionlab.server.http.head_requests import Heads
from motionlab.server.http.logins import Logins
from motionlab.server.http.security import Guard
from motionlab.server.jobs import Jobs
from motionlab.server.kernel_compiler import Kernels
from motionlab.server.live import messages
from motionlab.server.live.broadcast import Broadcast
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.live.sessions import Sessions
from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.own_laws import OwnLaws
from motionlab.server.plugs import drive_plug, without_drives
from motionlab.server.preload import warm_up
from motionlab.server.prometheus import Monitor
from motionlab.server.routes import (
    captures,
    expressions,
    fields,
    gain_sets,
    identification_plan,
    jobs,
    laws,
    layouts,
    login,
    loop,
    loop_response,
    maps,
    motors,
    paper,
    run_comparison,
    run_files,
    run_reports,
    runs,
    scenarios,
    scene,
    session_files,
    sessions,
    simulate,
    spectrum,
    studies,
    study_list,
    trajectories,
    view3d,
    views,
    whatif,
    whatif_captures,
    whatif_lanes,
)
from motionlab.server.settings import Settings
from motionlab.server.view3d.processes import Scenes
from motionlab.server.workers.pool import Workers

PREFIX = "/api/v1"

_LOG = logging.getLogger(__name__)

_MODULES = (
    login,
    scenarios,
    fields,
    simulate,
    jobs,
    whatif,
    whatif_captures,
    whatif_lanes,
    expressions,
    trajectories,
    sessions,
    view3d,
    session_files,
    captures,
    loop,
    loop_response,
    studies,
    study_list,
    maps,
    identification_plan,
    paper,
    run_comparison,
    run_files,
    run_reports,
    spectrum,
    views,
    runs,
    gain_sets,
    layouts,
    motors,
    laws,
)
"""Routes of the API, in the order of its documentation."""

_THREADS = 4
"""Threads of routes that are not coroutines: more would take the interpreter's lock from STOP."""

_DESCRIPTION = """\
Runs a simulated planar switched reluctance motor under several controllers on the same noise. All
numbers are SI. Errors are RFC 9457 problem documents."""

_TAGS = {
    "server": "Health, log-in and settings of the server",
    "scenarios": "Scenarios and parts that ship, their schema, and every field",
    "simulate": "Runs of a scenario, what-ifs, linearised loops and explanations of a peak",
    "jobs": "Long calls: their state, progress and result",
    "expressions": "Math channels",
    "trajectories": "Motions: saved, sampled, checked, imported and exported",
    "sessions": "Live sessions, which play at real speed or another",
    "design": "Sizing of a motor, force sharing and the platform",
    "maps": "Force maps by finite elements",
    "tune": "Gains by the simplex",
    "sweep": "A scenario over values of any fields",
    "montecarlo": "A scenario on many plausible motors",
    "learn": "A force learnt from lap to lap of a motion that repeats",
    "identify": "Friction by an experiment, or from a run",
    "paper": "Every number that the paper prints, recomputed",
    "studies": "Lists of studies and views, and those of one's own",
    "runs": "Kept runs and measurements: lists, files, comparisons, spectra, reports",
    "gain sets": "Named values of controllers",
    "layouts": "Named arrangements of the page",
    "motors": "Motors of one's own",
    "drive": "Six current drives on EtherCAT, and their commissioning",
}


def asyncapi() -> dict[str, Any]:
    """Return the description of the websocket."""
    return messages.asyncapi(__version__)


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    """Start what a server has beside its routes, and end it."""
    settings: Settings = app.state.settings
    current_default_thread_limiter().total_tokens = _THREADS
    app.state.memory = MemoryBudget(settings.memory_max)
    app.state.activities = []  # of plugs
    app.state.uploads = MemoryBudget(max(settings.memory_max // 4, settings.upload_max))
    app.state.writing = asyncio.Lock()  # of files, so that the other workers are free
    app.state.writing_long = asyncio.Lock()  # of those that take minutes
    app.state.downloads = asyncio.Semaphore(settings.downloads_max)
    app.state.downloads_waiting = 0
    app.state.broadcast = Broadcast()
    app.state.scenes = Scenes(most=settings.scenes_max)
    app.state.workers = Workers(
        count=settings.workers,
        waiting_max=settings.waiting_max,
        memory=app.state.memory,
        index_share=max(1, settings.workers // 2) if _index_is_remote() else None,
    )
    app.state.workers.start()
    recorder = app.state.recorder = RunRecorder(data_root(), app.state.workers)
    app.state.sessions = Sessions(
        most=settings.sessions_max, memory=app.state.memory, recorder=recorder
    )
    evictors = [
        asyncio.create_task(kept.keep_evicting()) for kept in (app.state.sessions, app.state.scenes)
    ]
    own_laws = app.state.own_laws = OwnLaws(app.state.sessions)
    watching = asyncio.create_task(own_laws.keep_watching())
    kernels = Kernels()
    app.state.jobs = Jobs(
        settings,
        forks=app.state.workers.forks,
        memory=app.state.memory,
        kernels=kernels,
        records=RecordStore(data_root() / "jobs"),
    )

    async def warm() -> None:
        await app.state.workers.forks.settled.wait()  # it compiles; here it is only loaded
        try:
            await asyncio.to_thread(warm_up)
        except Exception:
            _LOG.exception("not everything could be loaded beforehand")
        kernels.start()

    warming = asyncio.create_task(warm())
    async with _collecting_garbage(app):
        yield
    for evictor in evictors:
        evictor.cancel()
    await app.state.scenes.close()
    watching.cancel()
    own_laws.close()
    warming.cancel()  # what a thread does is still waited for
    with suppress(asyncio.CancelledError):
        await warming
    app.state.sessions.close()
    await recorder.close()
    await app.state.jobs.close()
    await app.state.workers.close()
    kernels.close()


def _index_is_remote() -> bool:
    return os.environ.get("MOTIONLAB_DATABASE_URL", "").startswith("postgres")


@asynccontextmanager
async def _collecting_garbage(app: FastAPI) -> AsyncIterator[None]:
    """Collect garbage where it delays no STOP, if this process serves nothing else."""
    if not app.state.owns_process:
        yield
        return
    garbage = GarbageCollection(lambda: _moving(app), lambda: app.state.memory.taken)
    garbage.begin()
    collecting = asyncio.create_task(garbage.keep_collecting())
    yield
    collecting.cancel()
    garbage.end()


def _moving(app: FastAPI) -> bool:
    """Return whether a session runs, or a plug is active."""
    sessions: Sessions = app.state.sessions
    return any(each.runs for each in sessions.all()) or any(each() for each in app.state.activities)


def create_app(settings: Settings | None = None) -> FastAPI:
    """Return the application."""
    settings = settings or Settings()
    plug = without_drives if settings.drive is None else drive_plug()
    app = _with_api(plug)
    app.state.settings = settings
    app.state.owns_process = False  # `serve` says otherwise
    app.state.logins = Logins(settings.token)
    monitor = app.state.monitor = Monitor()
    app.add_middleware(CompressedJson)
    app.add_middleware(Guard, settings=settings, logins=app.state.logins)
    app.add_middleware(Heads)
    app.add_middleware(AccessLog)
    app.add_middleware(ConnectionLimits)
    problems.install(app)
    app.include_router(scene.router)
    app.get("/asyncapi.json", include_in_schema=False)(asyncapi)

    @app.get("/metrics", include_in_schema=False)
    def metrics() -> PlainTextResponse:
        monitor.sessions.set(len(app.state.sessions.all()))
        return PlainTextResponse(monitor.text(), media_type=CONTENT_TYPE_LATEST)

    # The same whether or not a plug is loaded: clients are generated from it.
    openapi.install(app, settings, lambda: _with_api(drive_plug()).openapi())
    page.install(app)  # the last: it takes every other path
    return app


def _with_api(plug: APIRouter) -> FastAPI:
    """Return an application with the routes that its OpenAPI document describes."""
    app = FastAPI(
        title="PSRM Motion Lab",
        description=_DESCRIPTION,
        version=__version__,
        license_info={"name": "MIT", "identifier": "MIT"},
        servers=[{"url": "/", "description": "The server that answers with this document"}],
        openapi_tags=[{"name": name, "description": text} for name, text in _TAGS.items()],
        lifespan=_lifespan,
        separate_input_output_schemas=False,  # one name a model in generated clients
        openapi_url=None,  # `openapi.install` has its own
        docs_url=None,
        redoc_url=None,
        responses=problems.responses(400, 401, 403),
    )
    for module in _MODULES:
        app.include_router(module.router, prefix=PREFIX)
    app.include_router(plug, prefix=PREFIX)
    return app
