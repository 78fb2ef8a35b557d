"""Pages of HTML from the templates beside: whatever is not markup already is escaped."""

from __future__ import annotations

import functools
from datetime import UTC, datetime
from typing import Any

from jinja2 import Environment, PackageLoader

from motionlab.config.named_configs import names
from motionlab.library.description import DIFFERENCES_MAX
from motionlab.loop.linearise import SLIDING
from motionlab.loop.margins import MEANINGS
from motionlab.reports import history, results
from motionlab.reports.markup import FORBIDDEN, symbol
from motionlab.reports.quantities import digits, field_at, number, quantity, value_markup
from motionlab.reports.recipe import recipe
from motionlab.reports.svg_chart import DARK_LOOKS, LOOKS, spanned

_KINDS = {
    "simulation": "simulated",
    "live": "live session",
    "drive": "on drives",
    "measurement": "measured",
}


def page(template: str, title: str, **context: Any) -> bytes:
    """Return a whole page, which loads nothing; its only script is that of `experiment`."""
    text = _environment().get_template(template).render(title=title, **context)
    return f"{text}\n".encode("utf-8", errors="replace")


@functools.cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("motionlab.reports"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_printable,
    )
    environment.filters |= {
        "digits": digits,
        "instant": instant,
        "quantity": quantity,
        "span": span,
        "symbol": symbol,
    }
    environment.globals |= {
        "dark_looks": DARK_LOOKS,
        "definitions": results.definitions,
        "differences_max": DIFFERENCES_MAX,
        "event_count": history.event_count,
        "field_at": field_at,
        "kinds": _KINDS,
        "looks": LOOKS,
        "loops": results.loops,
        "meanings": MEANINGS,
        "number": number,
        "recipe": recipe,
        "shipped": names("scenarios"),
        "sliding": f"{SLIDING:g}",
        "spanned": spanned,
        "trajectory_rows": history.trajectory_rows,
        "value_markup": value_markup,
    }
    return environment


def _printable(value: Any) -> Any:
    """Replace what XML does not know; None is left out."""
    if value is None:
        return ""
    return value if hasattr(value, "__html__") else FORBIDDEN.sub("\ufffd", str(value))


def instant(seconds: float) -> str:
    """Return an instant since 1970 as date and time."""
    try:
        return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    except (OverflowError, ValueError, OSError):
        return "at an unknown time"


def span(seconds: float) -> str:
    """Return a length of time."""
    if seconds < 120.0:
        return f"{digits(seconds, 4)} s"
    return f"{int(seconds // 60)} min {digits(seconds % 60, 3)} s"
