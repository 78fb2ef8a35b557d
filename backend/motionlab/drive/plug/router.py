"""The plug of drives: their routes, and the link that lives while a server runs."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI

from motionlab.drive.plug import commissioning_routes, routes
from motionlab.drive.plug.drives import Drives
from motionlab.drive.plug.friction_step import FrictionStep
from motionlab.drive.plug.response_step import ResponseStep


@asynccontextmanager
async def _linked(app: FastAPI) -> AsyncIterator[None]:
    """Keep the link of a server's settings."""
    state = app.state
    drives = state.drives = Drives(state.settings.drive)
    served = (drives, state.sessions, state.workers)
    drives.torque_steps |= {"friction": FrictionStep(*served), "response": ResponseStep(*served)}
    state.activities.append(lambda: drives.active)
    try:
        yield
    finally:
        await drives.close()


router = APIRouter(lifespan=_linked)
router.include_router(routes.router)
router.include_router(commissioning_routes.router)
