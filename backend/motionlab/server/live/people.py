"""Who watches a session: their own names, or numbers of guests."""

from __future__ import annotations

import re
from collections.abc import Callable
from urllib.parse import unquote

from motionlab.library.run_name import one_line

NAME_MAX = 40
"""Characters of a name; what follows them is cut off."""

_ENCODED_MAX = 12 * NAME_MAX  # characters of a name in UTF-8, percent-encoded
_GUESTS_KEPT = 1000
_GUEST = re.compile(r"guest \d+", re.IGNORECASE)


def shown_name(text: str) -> str:
    """Return a name as others see it: one line of printable characters, NAME_MAX at most."""
    return one_line(text, NAME_MAX)


def decoded_name(header: str) -> str:
    """Return the name in a header, percent-encoded; whatever it holds, it is never refused."""
    return shown_name(unquote(header[:_ENCODED_MAX], errors="replace"))


class People:
    """Those who watch a session.

    The streams of one browser have one key: they are one person, who is the same guest again after
    a reload. Names are not verified: several people may have one.

    Parameters
    ----------
    changed : callable
        Called once somebody has come, left or taken another name.
    """

    def __init__(self, changed: Callable[[], None]) -> None:
        self.names: tuple[str, ...] = ()
        self._changed = changed
        self._keys: dict[object, object] = {}  # by stream
        self._own: dict[object, str] = {}  # names by key
        self._guests: dict[object, int] = {}  # numbers by key
        self._numbers = 0

    def enter(self, stream: object, *, key: str, name: str) -> str:
        """Take or rename who watches by a stream, and return the name by which others see them.

        Parameters
        ----------
        stream : object
            Its identity is that of the person where there is no key.
        key : str
            The same for all streams of a browser; empty for none.
        name : str
            What the person calls themselves; empty, or the form of a guest's, for a guest.
        """
        person = key or stream
        if self._keys.get(stream, person) != person:
            self._forget(stream)
        self._keys[stream] = person
        shown = shown_name(name)
        self._own[person] = "" if _GUEST.fullmatch(shown) else shown
        self._refresh()
        return self._name(person)

    def leave(self, stream: object) -> None:
        """Forget a stream, and who watched by it."""
        self._forget(stream)
        self._refresh()

    def _forget(self, stream: object) -> None:
        person = self._keys.pop(stream, None)
        if person not in self._keys.values():
            self._own.pop(person, None)
        if person is stream:  # who cannot come again
            self._guests.pop(person, None)

    def _name(self, person: object) -> str:
        return self._own[person] or f"Guest {self._number(person)}"

    def _number(self, person: object) -> int:
        """Return the number of a guest: theirs from before, or one that is new."""
        if person not in self._guests:
            self._numbers += 1
            self._guests[person] = self._numbers
            if len(self._guests) > _GUESTS_KEPT:
                absent = (each for each in self._guests if each not in self._own)
                self._guests.pop(next(absent, None), None)
        return self._guests[person]

    def _refresh(self) -> None:
        people = dict.fromkeys(self._keys.values())
        names = tuple(self._name(person) for person in people)
        if names != self.names:
            self.names = names
            self._changed()
