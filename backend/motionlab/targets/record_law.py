"""Why a law or an effect is not made of lanes, in words, before it is compiled or exported."""

from __future__ import annotations

import functools
import inspect
from typing import Any

from motionlab.effects import Effect, MidStep, Resistance
from motionlab.laws import Law
from motionlab.laws.law import Estimate, Seen
from motionlab.targets.record import Recorder
from motionlab.targets.record_arguments import zeros
from motionlab.targets.record_source import plain
from motionlab.targets.record_structures import class_of
from motionlab.targets.record_values import RecordError


@functools.cache
def lane_error(law: Law | Effect) -> str:
    """Return what in a step lanes do not have, naming function and module; empty if none."""
    step: Any = plain(law.step)
    known, answer = (MidStep, Resistance) if isinstance(law, Effect) else (Seen, Estimate)
    names = list(inspect.signature(step).parameters)
    if len(names) != 3:
        return f"{step.__name__} in {step.__module__}: takes {len(names)} arguments, not 3"
    values = (zeros(law.Parameters), zeros(law.State), zeros(known))
    try:
        result = Recorder(squares=False).record(step, dict(zip(names, values, strict=True))).result
    except RecordError as error:
        return str(error)
    pair = result if type(result) is tuple and len(result) == 2 else ()
    kinds = [class_of(each) if hasattr(each, "_fields") else type(each) for each in pair]
    if kinds != [answer, law.State]:
        pair = f"({answer.__name__}, {law.State.__name__})"
        return f"{step.__name__} in {step.__module__}: returns no {pair}"
    return ""
