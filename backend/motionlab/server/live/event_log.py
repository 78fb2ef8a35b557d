"""The latest events of a session, with who made them."""

from __future__ import annotations

import time

from motionlab.library.run import Event
from motionlab.timing import to_ticks

EVENTS_MAX = 100
"""Events since the reset that are kept; the recording has all those that it depends on."""

EARLIER_MAX = 200
"""Events before the reset that are kept, over all resets."""

_DRAG_SECONDS = 1.0
_DRAG = to_ticks(_DRAG_SECONDS)


class EventLog:
    """The latest events since the reset, and those before it.

    A dragged slider sends many changes: those of the same fields by the same person that follow
    each other within a second are one, from the first value before to the last one after. So are
    speeds, by the time of day.
    """

    def __init__(self) -> None:
        self.latest: tuple[Event, ...] = ()
        self.earlier: tuple[Event, ...] = ()

    def note(self, event: Event) -> Event:
        """Add an event with the time of day, and return it so."""
        event = event.model_copy(update={"at": round(time.time(), 3)})
        self.add(event)
        return event

    def add(self, event: Event) -> None:
        """Add an event; the oldest beyond EVENTS_MAX goes.

        A reset begins anew, since ticks do: all before it are earlier ones.
        """
        if event.kind == "reset":
            self.earlier = (*self.earlier, *self.latest)[-EARLIER_MAX:]
            self.latest = ()
        before = self.latest
        if before and _continues(event, before[-1]):
            event = event.model_copy(update={"previous": before[-1].previous})
            before = before[:-1]
        self.latest = (*before, event)[-EVENTS_MAX:]


def _continues(event: Event, last: Event) -> bool:
    if event.kind != last.kind or event.by != last.by:
        return False
    match event.kind:
        case "change":
            same = event.set.keys() == last.set.keys() and not event.undo and not last.undo
            return same and event.tick - last.tick < _DRAG
        case "speed":
            return (event.at or 0.0) - (last.at or 0.0) < _DRAG_SECONDS
        case _:
            return False
