"""Math channels checked: unit, channels and compiled steps, or what is wrong and where."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.library.library import library
from motionlab.library.run import ID
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.worker_answers import computed
from motionlab.telemetry.expressions.columns import MATH_MAX, compile_column
from motionlab.telemetry.expressions.parse import ExpressionError
from motionlab.telemetry.law_channels import all_columns, any_law
from motionlab.timing import CONTROL_PERIOD

router = APIRouter(prefix="/expressions", tags=["expressions"], route_class=JsonRoute)

_ASKED_MAX = 1000
"""Characters of a column that is checked: more than may be used, so that the answer can say so."""


class ExpressionsRequest(BaseModel):
    """Math channels, and whose channels they are of: a run's, or a scenario's variants."""

    model_config = ConfigDict(extra="forbid") | examples(
        {
            "columns": ["error=hypot(B.x.following_error, B.y.following_error)"],
            "variants": ["A", "B"],
        }
    )

    columns: list[Annotated[str, Field(max_length=_ASKED_MAX)]] = Field(
        min_length=1, max_length=MATH_MAX, description="name=expression each; docs/expressions.md"
    )
    variants: list[Annotated[str, Field(pattern=r"^[A-Z]$")]] = Field(
        default_factory=lambda: ["A", "B"], max_length=26, description="Without a run"
    )
    run: Annotated[str, Field(pattern=ID)] | None = Field(
        default=None, description="Identifier of a run"
    )


class ProgramStep(BaseModel):
    """An operation of a stack machine."""

    op: str
    values: list[float]


class ExpressionProblem(BaseModel):
    """What is wrong with a column, and with which of its characters [start, end)."""

    message: str
    start: int
    end: int


class CheckedExpression(BaseModel):
    """A math channel that can be computed, or why it cannot."""

    column: str
    name: str = Field(default="", description="Its name, or else its expression")
    unit: str = ""
    channels: list[str] = Field(default=[], description="What it reads, each once")
    steps: list[ProgramStep] = Field(default=[], description="docs/expressions.md")
    problem: ExpressionProblem | None = None


@router.post(
    "/check",
    operation_id="checkExpressions",
    response_model=list[CheckedExpression],
    responses=responses(400, 404, 409, 413, 415, 422, 429, 503),
)
async def check_expressions(
    request: Request, body: Annotated[ExpressionsRequest, Body()]
) -> Response:
    """Return unit, channels and steps of math channels, or what is wrong with each."""
    return await computed(request, _checked, body, light=True)


def _checked(body: ExpressionsRequest) -> list[CheckedExpression]:
    if body.run is None:
        units = {name: each.unit for name, each in all_columns(any_law(body.variants))}
        period = CONTROL_PERIOD
    else:
        run = library().complete(body.run)
        units = {each["name"]: each["unit"] for each in run.columns}
        period = run.period
    return [_one(column, units, period) for column in body.columns]


def _one(column: str, units: dict[str, str], period: float) -> CheckedExpression:
    try:
        compiled = compile_column(column, units, period)
    except ExpressionError as error:
        start, end = error.span
        problem = ExpressionProblem(message=error.message, start=start, end=end)
        return CheckedExpression(column=column, problem=problem)
    steps = [ProgramStep(op=step.op, values=list(step.values)) for step in compiled.program.steps]
    return CheckedExpression(
        column=column,
        name=compiled.name,
        unit=compiled.program.unit,
        channels=list(compiled.program.channels),
        steps=steps,
    )
