"""Trajectories: feasibility check, retiming, storage by name."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Body, Path, Query, Request, Response
from pydantic import BaseModel, Field
from starlette.convertors import StringConvertor, register_url_convertor

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import Epochs, epochs, load_scenario, validate_trajectory
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.exchange.paths.reading import ReadOptions, read_trajectory
from motionlab.exchange.paths.writing import ENDINGS, MEDIA_TYPES, write_trajectory
from motionlab.kernel.force_maps import map_digests
from motionlab.library import trajectories as library
from motionlab.library.trajectories import Trajectories, TrajectoryEntry
from motionlab.server.http.openapi_input import EXAMPLE_PATH, TrajectoryTable, examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.named_documents import DocumentRoutes
from motionlab.server.routes.simulate import ChangedScenario
from motionlab.server.worker_answers import NUMBERS, ComputedResponse, called, computed
from motionlab.server.workers.worker import Call
from motionlab.simulation.loop_check import Loops, run_loops
from motionlab.simulation.prepare import limit_sets, needs_plan, planned_for
from motionlab.telemetry.packed import packed
from motionlab.trajectories.corners import drawn
from motionlab.trajectories.retiming import slow_down
from motionlab.trajectories.spline import outline
from motionlab.trajectories.trajectory_check import Examination, LimitSets, examine


class _TrajectoryName(StringConvertor):
    """Names of trajectories; excludes those of operations."""

    regex = "(?!(?:check|slow|import|export)$)[^/]+"


register_url_convertor("trajectory", _TrajectoryName())

router = APIRouter(prefix="/trajectories", tags=["trajectories"], route_class=JsonRoute)

Name = Annotated[
    str, Path(pattern="^[a-z0-9-]{1,64}$", description="Name of a trajectory", examples=["circle"])
]
Table = Annotated[dict[str, Any], TrajectoryTable()]


class SlowRequest(ChangedScenario):
    """A trajectory, and the scenario whose motor and controllers are to follow it."""

    model_config = examples({"scenario": "circle", "trajectory": EXAMPLE_PATH})

    trajectory: Table = Field(description="`kind` and its numbers")
    points: int = Field(default=600, ge=10, le=20_000, description="Bins of each profile at most")


class CheckRequest(SlowRequest):
    """A trajectory, the scenario whose motor and controllers are to follow it, and whether to run.

    The loops are run along a feasible motion of at most 120 s, 600 s summed over variants.
    """

    loops: bool = Field(
        default=False,
        strict=True,
        description="Run every variant along it too; docs/trajectories.md",
    )


class KeptTrajectory(library.KeptTrajectory):
    """A trajectory with its numbers."""

    trajectory: Table = Field(description="As a scenario takes it, every field given")


class SlowedTrajectory(BaseModel):
    """A trajectory that the motor can follow."""

    trajectory: Table = Field(description="The same path with slower numbers")
    stretch: float = Field(ge=1.0, description="Stretch of time; 1 if it was feasible already")
    duration: float = Field(description="Time of the slower motion, s")


class ReadQuery(BaseModel):
    """What is said of a file; the rest it says itself."""

    format: Literal["auto", "csv", "svg", "gcode", "text"] = Field(
        default="auto", description="By its name or content; or text to be written"
    )
    filename: str = Field(
        default="", max_length=200, description="Name whose ending tells the format"
    )
    unit: Literal["m", "cm", "mm", "um", "nm", "in"] = Field(
        default="mm", description="Of lengths in CSV that name none"
    )
    scale: float = Field(default=1.0, ge=1e-6, le=1e6, description="Factor on all lengths")
    tolerance: float = Field(
        default=5e-6, ge=1e-7, le=1e-3, description="Largest distance of the path from the file, m"
    )
    placement: Literal["file", "centre", "fit"] = Field(
        default="file", description="As in the file, its middle at mid-stroke, or scaled to fit too"
    )
    stroke_x: float = Field(default=0.085, gt=0, le=1, description="Half the stroke to fit, m")
    stroke_y: float = Field(default=0.145, gt=0, le=1, description="Half the stroke to fit, m")
    height: float = Field(default=0.01, ge=1e-4, le=1, description="Of capitals of a text, m")
    samples: bool = Field(
        default=False, description="Keep the times of a table: a motion of kind samples"
    )


class ReadTrajectory(BaseModel):
    """A trajectory from a file of another program."""

    trajectory: Table = Field(description="A path, a sequence of paths and dwells, or samples")
    format: Literal["csv", "svg", "gcode", "text"] = Field(description="Format of the file")
    read: str = Field(description="What the file has")
    segments: int = Field(description="Lines, curves and arcs of the file, connecting moves too")
    moves: int = Field(description="Straight connecting moves between strokes among them")
    points: int = Field(description="Points of the path")
    corners: int = Field(description="Points at which the path has a corner")
    deviation: float = Field(description="Largest distance of the file from the path, m")
    notes: list[str] = Field(description="What was left out or taken otherwise")


class WriteRequest(ChangedScenario):
    """A trajectory to be written for another program.

    A time-optimal one is planned for the scenario's motor where it does not say for which.
    """

    model_config = examples({"format": "svg", "trajectory": EXAMPLE_PATH})

    trajectory: Table = Field(description="`kind` and its numbers")
    format: Literal["csv", "points", "svg", "gcode"] = Field(
        description="csv: time, x, y at every tick; points: x, y of the points"
    )


@router.post(
    "/import",
    operation_id="importTrajectory",
    response_model=ReadTrajectory,
    responses=responses(413, 422, 429, 503),
    openapi_extra={
        "requestBody": {
            "content": {
                "application/octet-stream": {
                    "schema": {
                        "type": "string",
                        "format": "binary",
                        "description": "CSV, SVG, G-code or text; docs/trajectories.md",
                        "examples": ["x [mm],y [mm]\n0,0\n10,0\n10,20\n"],
                    }
                }
            },
            "required": True,
        }
    },
)
async def import_trajectory(request: Request, query: Annotated[ReadQuery, Query()]) -> Response:
    """Return a trajectory from a file of another program; nothing is kept."""
    return await computed(request, _read, await request.body(), query)


@router.post(
    "/export",
    operation_id="exportTrajectory",
    response_class=Response,
    responses={
        200: {
            "description": "The file",
            "content": {
                media: {"schema": {"type": "string"}} for media in sorted(set(MEDIA_TYPES.values()))
            },
        },
        **responses(400, 413, 415, 422, 429, 503),
    },
)
async def export_trajectory(request: Request, body: Annotated[WriteRequest, Body()]) -> Response:
    """Return a trajectory as a file for other programs."""
    answer = await called(request, _written, body)
    name = f"trajectory.{ENDINGS[body.format]}"
    return ComputedResponse(
        answer,
        media_type=MEDIA_TYPES[body.format],
        headers={"Content-Disposition": f'attachment; filename="{name}"'},
    )


@router.post(
    "/check",
    operation_id="checkTrajectory",
    response_class=Response,
    responses={
        200: {
            "description": "Profiles, peaks and everything infeasible; docs/trajectories.md",
            "content": {NUMBERS: {"schema": {"type": "string", "format": "binary"}}},
        },
        **responses(400, 413, 415, 422, 429, 503),
    },
)
async def check_trajectory(request: Request, body: Annotated[CheckRequest, Body()]) -> Response:
    """Check a trajectory against a scenario's limits, for drawing; 200 also if it is infeasible."""
    answer = await called(request, _examined, body, light=not body.loops)
    return ComputedResponse(answer, media_type=NUMBERS)


@router.post(
    "/slow",
    operation_id="slowTrajectory",
    response_model=SlowedTrajectory,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def slow_trajectory(request: Request, body: Annotated[SlowRequest, Body()]) -> Response:
    """Stretch a trajectory in time, no more than needed, until the motor can follow it."""
    return await computed(request, _slowed, body)


_NOUNS = ("Trajectory", "Trajectories")
routes = DocumentRoutes(router, Trajectories, _NOUNS, Name, "/{name:trajectory}")
routes.list(TrajectoryEntry, "List the trajectories that ship and those that were saved.")
routes.get(KeptTrajectory, "Return a trajectory by name.")
routes.put(
    Annotated[Table, Body(examples=[EXAMPLE_PATH])],
    KeptTrajectory,
    "Save or replace a trajectory under a name.",
)
routes.delete("Delete a saved trajectory.")


def _read(content: bytes, query: ReadQuery) -> ReadTrajectory:
    options = ReadOptions(
        format=None if query.format == "auto" else query.format,
        unit=query.unit,
        scale=query.scale,
        tolerance=query.tolerance,
        placement=query.placement,
        stroke=(query.stroke_x, query.stroke_y),
        height=query.height,
        samples=query.samples,
    )
    reading = read_trajectory(content, options, name=query.filename)
    table = reading.trajectory.model_dump(mode="json")
    return ReadTrajectory.model_validate(vars(reading) | {"trajectory": table})


def _written(_: Call, body: WriteRequest) -> bytes:
    return write_trajectory(_trajectory(body), body.format).encode()


def _examined(call: Call, body: CheckRequest) -> bytes:
    return _checked(body, call.hold)


def _checked(body: CheckRequest, hold: Callable[[int], None] = lambda _size: None) -> bytes:
    trajectory = _trajectory(body)
    examination = examine(trajectory, _limits(body), bins=body.points)
    curves = [each for p in examination.profiles for each in (p.minimum, p.maximum)]
    loops = Loops(loops_not_run="not asked for")
    if body.loops:
        (_, scenario), *_ = _epochs_of(json.dumps([body.scenario, body.set]))
        changed = scenario.model_copy(update={"trajectory": trajectory})
        loops = run_loops(changed, examination, hold)
    head = _head(examination) | loops.document() | {"outline": None, "drawn": None}
    if not isinstance(trajectory, DrawnPath):
        path = drawn(trajectory)
        head["drawn"] = path and path.model_dump(mode="json")
    elif trajectory.geometry == "spline":
        places, edges = outline(
            trajectory.points, closed=trajectory.closed, corners=trajectory.corners
        )
        begin, count = sum(map(len, curves)), len(edges)
        columns = {name: begin + k * count for k, name in enumerate(("x", "y", "edge"))}
        head["outline"] = columns | {"count": count}
        curves += [places[:, 0], places[:, 1], edges]
    return packed(head, curves)


def _head(examination: Examination) -> dict[str, Any]:
    count = len(examination.profiles[0].minimum)
    return {
        "feasible": examination.feasible,
        "duration": examination.duration,
        "examined": examination.examined,
        "length": examination.length,
        "extent": examination.extent,
        "time": {"start": 0.0, "step": examination.step, "count": count},
        "peaks": [vars(peak) for peak in examination.peaks],
        "violations": [vars(each) for each in examination.violations],
        "violation_count": examination.violation_count,
        "thrust_reserve": examination.reserve,
        "notes": examination.notes,
        "columns": [
            {
                "name": profile.name,
                "unit": profile.unit,
                "minimum": index * 2 * count,
                "maximum": (index * 2 + 1) * count,
            }
            for index, profile in enumerate(examination.profiles)
        ],
    }


def _slowed(body: SlowRequest) -> SlowedTrajectory:
    limits = _limits(body)
    slower, stretch = slow_down(_trajectory(body), limits)
    duration = examine(slower, limits, bins=10).duration
    return SlowedTrajectory(
        trajectory=slower.model_dump(mode="json"), stretch=stretch, duration=duration
    )


def _trajectory(body: SlowRequest | WriteRequest) -> TrajectoryConfig:
    """Return the trajectory, planned for the scenario's motor if it is time-optimal."""
    trajectory = validate_trajectory(body.trajectory)
    (_, scenario), *_ = _epochs_of(json.dumps([body.scenario, body.set]))
    if not needs_plan(trajectory):
        return trajectory
    return trajectory.model_copy(update={"planned_for": planned_for(scenario)})


def _limits(body: SlowRequest) -> LimitSets:
    text = json.dumps([body.scenario, body.set])
    return _limits_of(text, map_digests(_epochs_of(text)))


# Dragging a path repeats the same request.


@functools.lru_cache(maxsize=16)
def _epochs_of(scenario_and_changes: str) -> Epochs:
    scenario, changes = json.loads(scenario_and_changes)
    return epochs(load_scenario(scenario, changes))


@functools.lru_cache(maxsize=16)
def _limits_of(scenario_and_changes: str, _maps: tuple[str, ...]) -> LimitSets:
    return limit_sets(_epochs_of(scenario_and_changes))
