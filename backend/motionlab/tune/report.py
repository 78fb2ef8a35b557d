"""A search for gains as text for people."""

from __future__ import annotations

import math

from motionlab.tune.document import Candidate, TunedGroup, TuneDocument

_HEAD = ("k_p", "k_d", "peak", "rms", "effort", "gain m.", "phase m.", "Ms", "cost")
_UNITS = ("N/mm", "N s/mm", "um", "um", "N", "1", "deg", "1", "")
_WIDTH = 10


def report(found: TuneDocument) -> str:
    """Return a table of candidates for each axis, warnings below it.

    Parameters
    ----------
    found : TuneDocument
        From `motionlab.tune.search.tune`.

    Returns
    -------
    str
        Several lines.
    """
    wanted = " + ".join(
        metric if weight == 1.0 else f"{weight:g} {metric}"
        for metric, weight in found.objective.items()
    )
    start, end = found.window
    lines = [
        f"{found.scenario}, gains of {found.variant} on {', '.join(found.plants)}: least {wanted} "
        f"from {start:g} to {end:g} s, {found.evaluations} sets of gains tried",
    ]
    for group in found.groups:
        lines += ["", *_group(group, found.plants)]
    if found.set:
        lines += ["", "the best of it:"]
        lines += [f"  --set {path}={value:.6g}" for path, value in found.set.items()]
    lines += [f"warning: {warning}" for warning in found.warnings]
    return "\n".join(lines)


def _group(group: TunedGroup, plants: list[str]) -> list[str]:
    worst = ", worst motor" if len(plants) > 1 else ""
    lines = [_row("", _HEAD), _row(f"{' and '.join(group.axes)}{worst}", _UNITS)]
    for candidate in (group.present, group.paper, *group.candidates):
        lines += _candidate(candidate)
    for number, start in enumerate(group.starts):
        lines.append(f"  start {number}: {start.ended} after {len(start.cost)} evaluations")
    return lines


def _candidate(candidate: Candidate) -> list[str]:
    name = candidate.origin if candidate.start is None else f"start {candidate.start}"
    lines = []
    for axis, tuned in candidate.axes.items():
        metrics, margins = tuned.metrics.values(), tuned.margins
        cells = [
            f"{tuned.k_p / 1e3:.1f}",
            f"{tuned.k_d / 1e3:.3f}",
            _worst([m.peak for m in metrics], 1e6),
            _worst([m.rms for m in metrics], 1e6),
            _worst([m.effort for m in metrics], 1.0),
            "-" if margins is None else _number(margins.gain_margin),
            "-" if margins is None else _number(margins.phase_margin, 180.0 / math.pi),
            "-" if margins is None else _number(margins.Ms),
            _number(candidate.cost),
        ]
        lines.append(_row(f"  {name} {axis}", cells))
    lines += [f"      {path} = {value:.4g}" for path, value in candidate.also.items()]
    lines += [f"      not held: {violation}" for violation in candidate.violations]
    return lines


def _row(name: str, cells: tuple[str, ...] | list[str]) -> str:
    return name.ljust(22) + "".join(cell.rjust(_WIDTH) for cell in cells)


def _worst(values: list[float | None], scale: float) -> str:
    known = [value for value in values if value is not None]
    return "ran away" if len(known) < len(values) else _number(max(known), scale)


def _number(value: float | None, scale: float = 1.0) -> str:
    return "-" if value is None else f"{value * scale:.4g}"
