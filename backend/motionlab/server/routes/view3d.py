"""Forces of each phase for the 3-D view, and the choices of its viewers."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from fastapi import APIRouter, HTTPException, Path, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.planar import AXES
from motionlab.scene3d.view_settings import Arrow, CameraName, ViewSettings
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.sessions import FoundSession
from motionlab.server.view3d.phase_forces import air_gap, newest
from motionlab.timing import CONTROL_PERIOD

router = APIRouter(prefix="/sessions", tags=["sessions"], route_class=JsonRoute)

VIEWER = "^[a-z0-9]{8,32}$"
"""Form of the name that a page gives its view."""

ViewerName = Annotated[
    str, Path(pattern=VIEWER, description="The page's name of its view", examples=["a1b2c3d4"])
]
Number = float | None
Three = tuple[Number, Number, Number]


class MoverForces(BaseModel):
    """The movers of one axis at the newest tick, SI; null where there is no number."""

    position: Number = Field(description="True position, m")
    following_error: Number = Field(description="Reference less measured position, m")
    thrust: Number = Field(description="N")
    normal_force: Number = Field(description="Of the three phases, N")
    friction: Number = Field(description="True friction, N")
    current: Three = Field(description="Of phases a, b, c, A")
    phase_thrust: Three = Field(description="Of phases a, b, c, N")
    phase_normal_force: Three = Field(description="Of phases a, b, c, N")
    to_aligned: Three = Field(description="From each phase to its nearest aligned position, m")


class PhaseForcesAnswer(BaseModel):
    """Forces of each phase at the newest tick."""

    tick: int
    time: float = Field(description="s")
    air_gap: dict[str, float] = Field(description="Of each axis, constant in the simulation, m")
    variants: dict[str, dict[str, MoverForces]] = Field(description="By variant and axis")


class SceneViewRequest(BaseModel):
    """What a 3-D view shows."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False) | examples(
        {"camera": "section", "machine": "B", "axis": "x", "magnification": 200.0}
    )

    camera: CameraName = "overview"
    machine: str = Field(default="A", pattern="^[A-Z]$", description="That is followed or cut")
    axis: Literal["x", "y"] = Field(default="x", description="Of the section")
    ghost: bool = Field(
        default=False, description="Draw the second machine translucent in the frame of the first"
    )
    magnification: float = Field(
        default=1.0, ge=1.0, le=1e6, description="Of errors, except in the section"
    )
    arrows: list[Arrow] = Field(
        default=["thrust", "phases", "normal", "friction", "load"],
        max_length=5,
        description="Forces that are drawn",
    )


@router.get(
    "/{session_id}/phase-forces", operation_id="getPhaseForces", responses=responses(404, 409)
)
def get_phase_forces(session: FoundSession) -> PhaseForcesAnswer:
    """Return thrust and normal force of each phase at the newest tick, by the plant's force map."""
    sample = newest(session)
    if sample is None:
        raise HTTPException(409, "the session has no sample yet: play it, or step")
    plant = session.simulation.scenario.plant
    movers = {
        variant: {
            axis: MoverForces(
                **dict(
                    zip(
                        ("position", "following_error", "thrust", "normal_force", "friction"),
                        map(_number, sample.values[v, a, :5]),
                        strict=True,
                    )
                ),
                current=_three(sample.values[v, a, 5:]),
                phase_thrust=_three(sample.forces[v, a, 0]),
                phase_normal_force=_three(sample.forces[v, a, 1]),
                to_aligned=_three(sample.to_aligned[v, a]),
            )
            for a, axis in enumerate(AXES)
        }
        for v, variant in enumerate(session.variants)
    }
    gaps = {axis: air_gap(getattr(plant, axis).force_map) for axis in AXES}
    return PhaseForcesAnswer(
        tick=sample.tick, time=sample.tick * CONTROL_PERIOD, air_gap=gaps, variants=movers
    )


@router.put(
    "/{session_id}/view3d/{viewer}",
    operation_id="putView3d",
    status_code=204,
    responses=responses(400, 404, 413, 415, 422),
)
async def put_view(
    request: Request, session: FoundSession, viewer: ViewerName, body: SceneViewRequest
) -> Response:
    """Choose what the 3-D view of this name shows; its page may connect later."""
    scene = request.app.state.scenes.find(session)
    if scene is None:
        raise HTTPException(404, f"session {session.id!r} is not shown in 3-D")
    chosen = body.model_dump()
    scene.configure(viewer, ViewSettings(**{**chosen, "arrows": tuple(chosen["arrows"])}))
    return Response(status_code=204)


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _three(values: object) -> Three:
    a, b, c = map(_number, values)  # type: ignore[call-overload]
    return a, b, c
