"""The application: routes, guard, problems, and documentation that works offline."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import swagger_ui_bundle
from fastapi import FastAPI
from fastapi.concurrency import run_in_threadpool
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse, PlainTextResponse
from fastapi.staticfiles import StaticFiles
from prometheus_client import CONTENT_TYPE_LATEST

from motionlab import __version__
from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.design.fem.compute import compute
from motionlab.design.fem.geometry import Geometry
from motionlab.service import messages, openapi, problems
from motionlab.service.heads import Heads
from motionlab.service.jobs import Jobs
from motionlab.service.kernels import Kernels
from motionlab.service.memory import Memory
from motionlab.service.monitor import Monitor
from motionlab.service.routes import (
    design,
    frequency,
    identify,
    jobs,
    login,
    loop,
    maps,
    measured,
    montecarlo,
    paper,
    scenarios,
    scene,
    sessions,
    sharing,
    simulate,
    trajectories,
    tune,
    whatif,
)
from motionlab.service.scenes import Scenes
from motionlab.service.security import Guard
from motionlab.service.sessions import Sessions
from motionlab.service.settings import Settings
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.store.files import data_root
from motionlab.store.records import RecordStore

PREFIX = "/api/v1"

_SWAGGER = sorted(Path(swagger_ui_bundle.__file__).parent.glob("vendor/swagger-ui-*"))[-1]
_PREVIEWS_AFTER = 3.0
"""Until what only previews need is imported, s: the first session and its stream come first."""

_DESCRIPTION = """\
Runs a simulated planar switched reluctance motor under several controllers on the same noise. All
numbers are SI. Errors are RFC 9457 problem documents."""


def page_root() -> Path | None:
    """Return the folder of the built page, in the package or the checkout, if it is there."""
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "page", package.parent.parent / "frontend" / "dist"):
        if (folder / "index.html").is_file():
            return folder
    return None


def warm_up() -> None:
    """Load, or on the first start compile, what simulations and paths need."""
    changes = {"trajectory": {"kind": "point", "duration": CONTROL_PERIOD}}
    prepared = prepare(load_scenario("circle", changes))
    document(prepared, run(prepared))
    trajectories.warm_up()


def warm_up_previews() -> None:
    """Import scipy and skfem, which previews of force maps need, by making one."""
    compute(Geometry(), "preview")


def create_app(settings: Settings | None = None) -> FastAPI:
    """Return the application.

    Parameters
    ----------
    settings : Settings, optional
        Token, hosts and bounds; loopback without a token when left out.

    Returns
    -------
    FastAPI
        Ready to be served.
    """
    settings = settings or Settings()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        app.state.memory = Memory(settings.memory_max)
        app.state.slots = asyncio.Semaphore(settings.running_max)
        app.state.jobs = Jobs(
            at_once=settings.jobs_at_once,
            waiting_max=settings.jobs_max,
            kept_max=settings.jobs_kept,
            records=RecordStore(data_root() / "jobs"),
        )
        app.state.sessions = Sessions(most=settings.sessions_max, memory=app.state.memory)
        app.state.scenes = Scenes(most=settings.scenes_max)
        sweepers = [
            asyncio.create_task(kept.sweep()) for kept in (app.state.sessions, app.state.scenes)
        ]
        app.state.kernels = Kernels()

        async def warm() -> None:
            await run_in_threadpool(warm_up)
            app.state.kernels.start()
            await asyncio.sleep(_PREVIEWS_AFTER)
            await run_in_threadpool(warm_up_previews)

        warming = asyncio.create_task(warm())
        yield
        for sweeper in sweepers:
            sweeper.cancel()
        await app.state.scenes.close()
        warming.cancel()  # what a thread does is still waited for
        with suppress(asyncio.CancelledError):
            await warming
        app.state.sessions.close()
        app.state.kernels.close()
        app.state.jobs.close()

    app = FastAPI(
        title="PSRM Motion Lab",
        description=_DESCRIPTION,
        version=__version__,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        responses=problems.responses(400, 401, 403),
    )
    app.state.settings = settings
    monitor = app.state.monitor = Monitor()
    app.add_middleware(Guard, settings=settings)
    app.add_middleware(Heads)
    problems.install(app)
    for module in (
        login,
        scenarios,
        simulate,
        jobs,
        whatif,
        trajectories,
        sessions,
        measured,
        loop,
        frequency,
        design,
        sharing,
        maps,
        identify,
        montecarlo,
        paper,
        tune,
    ):
        app.include_router(module.router, prefix=PREFIX)
    app.include_router(scene.router)
    app.mount("/docs/assets", StaticFiles(directory=_SWAGGER))

    @app.get("/docs", include_in_schema=False)
    def docs() -> HTMLResponse:
        return get_swagger_ui_html(
            openapi_url="/openapi.json",
            title="PSRM Motion Lab API",
            swagger_js_url="/docs/assets/swagger-ui-bundle.js",
            swagger_css_url="/docs/assets/swagger-ui.css",
            swagger_favicon_url="/docs/assets/favicon-32x32.png",
        )

    @app.get("/asyncapi.json", include_in_schema=False)
    def asyncapi() -> dict[str, Any]:
        return messages.asyncapi(__version__)

    @app.get("/metrics", include_in_schema=False)
    def metrics() -> PlainTextResponse:
        monitor.sessions.set(len(app.state.sessions.all()))
        return PlainTextResponse(monitor.text(), media_type=CONTENT_TYPE_LATEST)

    page = page_root()
    if page is not None:
        app.mount("/", StaticFiles(directory=page, html=True))

    openapi.install(app, settings)
    return app
