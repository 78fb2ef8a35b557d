"""Texts of other programs: which encoding they are in."""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence

from motionlab.errors import ConfigError, FieldError

_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),  # before UTF-16, whose mark begins it
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECLARED = re.compile(rb"""<\?xml\s[^>]{0,200}?encoding\s*=\s*["']([A-Za-z0-9._-]{1,40})["']""")
_NOT_CP1252 = re.compile(rb"[\x81\x8d\x8f\x90\x9d]")
DOS_END = "\x1a"
"""Ctrl-Z: the end of a text to DOS, which some programs and machines still write."""

_BEGINS_CELL = re.compile(r'(?:^|[,;\t])[ ]*"[^"]*$')
_CELL_LINES = 4  # that a cell ends after, or its quotation mark is a letter
_ENDS = re.compile(r"\r\n|\r|\n")
_ZEROS = 0.3  # share of zero bytes from which two bytes are a letter
_DECLARATION_MAX = 1000  # bytes
_LOOKED_AT = 1 << 16  # bytes


def encoding_of(head: bytes, *, whole: bool = True) -> str | None:
    """Return the encoding of a text by its first bytes; None if it is no text.

    Parameters
    ----------
    head : bytes
        The text or its beginning.
    whole : bool
        Whether it is all of the text; otherwise its last letter may be cut.
    """
    mark = next((name for mark, name in _MARKS if head.startswith(mark)), None)
    if mark is not None:
        return mark
    if b"\0" in head:
        return _wide(head[:_LOOKED_AT])
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head, final=whole)
    except UnicodeDecodeError:
        return "latin-1" if _NOT_CP1252.search(head) else "cp1252"
    return "utf-8"


def _wide(head: bytes) -> str | None:
    """Return UTF-16 without its mark, if zeros stand at every other place only."""
    even, odd = head[::2].count(0), head[1::2].count(0)
    half = _ZEROS * len(head) / 2.0
    if odd > half and even == 0:
        return "utf-16-le"
    return "utf-16-be" if even > half and odd == 0 else None


def decoded(content: bytes) -> tuple[str, str]:
    """Return a text and the encoding it is in; XML may declare it.

    Raises
    ------
    ConfigError
        With the line that is no text.
    """
    encoding = encoding_of(content)
    declared = _DECLARED.match(content[:_DECLARATION_MAX].lstrip())
    if declared and encoding in {"cp1252", "latin-1"}:  # whatever is declared, UTF-8 shows itself
        encoding = _named(declared[1].decode(), encoding)
    if content.startswith(b"\x1f\x8b"):
        raise ConfigError(FieldError("file", "is compressed (gzip, SVGZ): unpack it first"))
    if encoding is None:
        number = content.count(b"\n", 0, content.find(b"\0")) + 1
        raise ConfigError(FieldError(f"line {number}", "is no text"))
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        number = content.count(b"\n", 0, error.start) + 1
        message = f"is no text in {encoding.upper()}"
        raise ConfigError(FieldError(f"line {number}", message, content[error.start])) from None
    if (at := text.find("\0")) >= 0:
        raise ConfigError(FieldError(f"line {text.count(chr(10), 0, at) + 1}", "is no text"))
    return text, encoding


def _named(declared: str, detected: str) -> str:
    """Return a declared encoding, or the one detected where the text cannot be in the declared."""
    try:
        name = codecs.lookup(declared).name
        ascii_like = "<?xml?>".encode(name) == b"<?xml?>"  # or the declaration is not readable
    except (LookupError, UnicodeError, TypeError, ValueError):
        message = "declares an encoding that is not known: save it in UTF-8"
        raise ConfigError(FieldError("line 1", message, declared)) from None
    return detected if name in {"utf-8", "iso8859-1"} or not ascii_like else name


def lines_of(text: str) -> list[str]:
    r"""Return the lines of a text; only ``\n``, ``\r\n`` and ``\r`` end one.

    What DOS ends a text with is no line.
    """
    if (ended := text.rstrip("\r\n")).endswith(DOS_END):
        text = ended.rstrip(DOS_END)
    lines = _ENDS.split(text)
    return lines[:-1] if lines[-1] == "" else lines


def with_whole_cells(lines: Sequence[str]) -> list[str]:
    """Return lines of a table, those with a cell over several lines in one, empty ones before it.

    So every line after such a cell keeps its number. Spreadsheets write names this way.
    """
    whole = list(lines)
    begun = -1  # line in which a cell has begun that no line has ended yet
    for index, text in enumerate(whole):
        quotes = text.count('"') % 2
        if begun < 0 and quotes and _BEGINS_CELL.search(text):
            begun = index
        elif begun >= 0 and quotes:
            whole[index] = " ".join(part.strip() for part in whole[begun : index + 1])
            whole[begun:index] = [""] * (index - begun)
            begun = -1
        elif begun >= 0 and index - begun >= _CELL_LINES:
            begun = -1
    return whole
