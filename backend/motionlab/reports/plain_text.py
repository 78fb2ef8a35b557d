"""Text from outside without what a terminal would carry out or hide."""

from __future__ import annotations

import re
from typing import Any

_HIDDEN = (
    "\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f"  # C0 but tab and line ends, DEL, C1
    "\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"  # order of writing, other line ends
)
_CONTROL = re.compile(f"[{_HIDDEN}]|\r(?!\n)")
_STYLE = re.compile("(\x1b\\[[0-9]{1,2}(?:;1)?m)")

_LETTER = r"\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"
_UNSEEN = r"\s\u00ad\u200b-\u200d\u2060\ufeff"
NAME_PATTERN = rf"^[^{_LETTER}]*[^{_LETTER}{_UNSEEN}][^{_LETTER}]*$"
"""What a name that others see may consist of: letters, at least one that is seen."""


def without_controls(text: str) -> str:
    """Return a text with control characters, and marks of the order of writing, as escapes."""
    return _CONTROL.sub(lambda match: _escaped(match[0]), text)


def _escaped(letter: str) -> str:
    code = ord(letter)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


class PlainStream:
    """A text stream that writes no control characters but styles of letters and line ends."""

    def __init__(self, stream: Any, *, styled: bool) -> None:
        self._stream = stream
        self._styled = styled

    def __getattr__(self, name: str) -> Any:
        """Return what the stream has."""
        return getattr(self._stream, name)

    @property
    def direct(self) -> Any:
        """The stream itself, for what moves the cursor."""
        return self._stream

    def flush(self) -> None:
        """Write what is buffered."""
        self._stream.flush()

    def write(self, text: str) -> int:
        """Write a text."""
        if self._styled:
            parts = _STYLE.split(text)  # styles are at odd places
            parts[::2] = map(without_controls, parts[::2])
            self._stream.write("".join(parts))
        else:
            self._stream.write(without_controls(text))
        return len(text)
