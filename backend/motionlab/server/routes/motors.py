"""Motors: those that ship, and those of one's own, which scenarios find by name."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Path

from motionlab.library.motors import KeptMotor, Motor, MotorEntry, Motors
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.named_documents import DocumentRoutes

router = APIRouter(prefix="/motors", tags=["motors"], route_class=JsonRoute)

Name = Annotated[
    str, Path(pattern="^[a-z0-9-]{1,64}$", description="Name of a motor", examples=["nominal"])
]
_EXAMPLE = {"plant": {"base": "nominal", "x": {"mass": 6.1}}}


routes = DocumentRoutes(router, Motors, ("Motor", "Motors"), Name)
routes.list(MotorEntry, "List the motors that ship and those of one's own.")
routes.get(KeptMotor, "Return a motor by name, every field given.")
routes.put(
    Annotated[Motor, Body(examples=[_EXAMPLE])],
    KeptMotor,
    "Save or replace a motor of one's own, such as `motor` of an identification from a run.",
)
routes.delete("Delete a motor of one's own; scenarios and runs that have it keep its numbers.")
