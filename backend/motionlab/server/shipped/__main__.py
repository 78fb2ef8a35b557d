"""Compute the results that the screens open with: ``python -m motionlab.server.shipped [KIND]``.

They take minutes; `make results` computes all of them.
"""

from __future__ import annotations

import gzip
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

from pydantic import BaseModel

from motionlab import __version__
from motionlab.config.load import load_scenario
from motionlab.executors.progress import share_done
from motionlab.lanes import model_hash
from motionlab.server.job_reports import REPORT, JobSummary, subject_of
from motionlab.server.shipped import id_of, path_of
from motionlab.studies.table import BY_KIND

_DRAWN = {"reproduce": "figures", "landscape": "axes"}
"""Large parts of results that are only drawn: their long lists of numbers are rounded."""
_MANY = 24
_DIGITS = 4


def requests() -> dict[str, dict[str, Any]]:
    """Return the questions that the forms of the screens begin with, by kind."""
    circle = {"scenario": load_scenario("circle").model_dump(mode="json"), "set": {}}
    gains = circle | {"variant": "B", "plants": ["matched"]}
    k_p = circle["scenario"]["variants"]["B"]["controller"]["x"]["k_p"]
    swept = {
        "path": "variants.B.controller.x.k_p",
        "start": float(f"{k_p / 2:.2g}"),
        "stop": float(f"{k_p * 2:.2g}"),
        "count": 9,
        "scale": "log",
    }
    return {
        "reproduce": {},
        "tune": gains | {"also": {}},
        "landscape": gains | {"points": 64},
        "sweep": circle | {"grid": [swept], "combine": "grid"},
        "identify": circle | {"variant": "A", "apply_to": "B"},
    }


def rounded(result: Any) -> Any:
    """Return a document whose lists of many numbers, curves and maps, are rounded."""
    if isinstance(result, dict):
        return {key: rounded(value) for key, value in result.items()}
    if not isinstance(result, list):
        return result
    if sum(isinstance(each, float) for each in result) < _MANY:
        return [rounded(each) for each in result]
    return [float(f"{each:.{_DIGITS}g}") if each else each for each in result]


def record(kind: str, request: dict[str, Any]) -> tuple[bytes, bytes]:
    """Return summary and report of a study that is computed now."""
    study = BY_KIND[kind]
    created = datetime.now(UTC).replace(microsecond=0).isoformat().replace("+00:00", "Z")
    began = time.monotonic()
    with share_done(kind) as tell:
        progress: Callable[..., None] = lambda share, *_: tell(share)  # noqa: E731
        document = study.document(study.run(study.plan(request), progress))
    result = document.model_dump(mode="json", by_alias=True)
    if drawn := _DRAWN.get(kind):
        result[drawn] = rounded(result[drawn])
    summary = {
        "id": id_of(kind),
        "kind": kind,
        "state": "done",
        "progress": 1.0,
        "created": created,
        "elapsed": round(time.monotonic() - began, 1),
        "remaining": None,
        "error": None,
        "subject": subject_of(request),
        "version": __version__.partition("+")[0],
        "model": model_hash(),
        "shipped": True,
        "request": request,
    }
    report = {**summary, "partial": None, "result": result}
    return _json(JobSummary(**summary)), _json(REPORT.validate_python(report))


def write(kinds: list[str]) -> None:
    """Compute and write some of the results, or all."""
    questions = requests()
    for kind in kinds or questions:
        content = b"%s\n%s\n" % record(kind, questions[kind])
        path = path_of(kind)
        path.write_bytes(gzip.compress(content, 9, mtime=0))
        print(f"{path}: {path.stat().st_size} bytes", file=sys.stderr)


def _json(document: BaseModel) -> bytes:
    return document.model_dump_json(by_alias=True).encode()


if __name__ == "__main__":
    write(sys.argv[1:])
