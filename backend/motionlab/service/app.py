"""The application: routes, guard, problems, and documentation that works offline."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
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
from motionlab.service import messages, problems
from motionlab.service.jobs import Jobs
from motionlab.service.monitor import Monitor
from motionlab.service.registry import Sessions
from motionlab.service.routes import login, scenarios, sessions, simulate, whatif
from motionlab.service.security import Guard
from motionlab.service.settings import Settings
from motionlab.simulation.result import document
from motionlab.simulation.run import prepare, run

PREFIX = "/api/v1"

_SWAGGER = sorted(Path(swagger_ui_bundle.__file__).parent.glob("vendor/swagger-ui-*"))[-1]
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
    """Load, or on the first start compile, what every simulation needs."""
    changes = {"trajectory": {"kind": "point", "duration": CONTROL_PERIOD}}
    prepared = prepare(load_scenario("circle", changes))
    document(prepared, run(prepared))


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
        app.state.slots = asyncio.Semaphore(settings.running_max)
        app.state.jobs = Jobs(waiting_max=settings.jobs_max, kept_max=settings.jobs_kept)
        app.state.sessions = Sessions(most=settings.sessions_max)
        sweeper = asyncio.create_task(app.state.sessions.sweep())
        warming = asyncio.create_task(run_in_threadpool(warm_up))
        yield
        sweeper.cancel()
        await warming
        await app.state.sessions.close()
        app.state.jobs.close()

    app = FastAPI(
        title="PSRM Motion Lab",
        description=_DESCRIPTION,
        version=__version__,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        responses=problems.responses(401, 403),
    )
    app.state.settings = settings
    monitor = app.state.monitor = Monitor()
    app.add_middleware(Guard, settings=settings)
    problems.install(app)
    for module in (login, scenarios, simulate, whatif, sessions):
        app.include_router(module.router, prefix=PREFIX)
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

    default_openapi = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            schema = default_openapi()
            schemas = schema["components"]["schemas"]
            for model in (problems.Problem, problems.ProblemField):
                schemas[model.__name__] = model.model_json_schema(
                    ref_template="#/components/schemas/{model}"
                )
                schemas[model.__name__].pop("$defs", None)
            schemas.update(messages.schemas())
            for unused in ("HTTPValidationError", "ValidationError"):
                schemas.pop(unused, None)
            for operations in schema["paths"].values():
                for operation in operations.values():  # where FastAPI has put its own
                    if "application/json" in operation["responses"].get("422", {}).get(
                        "content", {}
                    ):
                        operation["responses"]["422"] = problems.responses(422)[422]
        return app.openapi_schema or {}

    app.openapi = openapi
    return app
