"""Docstrings as C comments."""

from __future__ import annotations

import re
import textwrap

from motionlab.targets.c_expression import WIDTH

_UNDERLINE = re.compile(r"\n[^\n]*\n-{3,}\n")
_ROLE = re.compile(r":\w+:`~?([^`]*)`")
_WORDS = {"each lane": "each axis", "a lane": "an axis", "the lane": "the axis"}
"""A lane of an exported program is one axis of its motor."""


def in_words_of_c(text: str) -> str:
    """Return a comment of a lane function as one of a function of an axis."""
    for word, other in _WORDS.items():
        text = text.replace(word, other)
    return text


def inside_comment(text: str) -> str:
    """Return a line of a comment that neither ends it nor begins another."""
    return in_words_of_c(text).replace("*/", "* /").replace("/*", "/ *")


def comment(text: str, indent: str = "") -> list[str]:
    """Return a docstring's summary, equations and source as the lines of a comment."""
    text = _UNDERLINE.split(text.strip())[0].strip()  # no numpydoc sections: C has types
    if not text:
        return []
    text = _ROLE.sub(r"\1", text).replace("``", "").replace("`", "").replace("::\n", ":\n")
    text = inside_comment(text)
    lines = text.splitlines()
    if len(lines) == 1 and len(indent) + len(lines[0]) + 6 <= WIDTH:
        return [f"{indent}/* {lines[0]} */"]
    inside = _reflowed(lines, WIDTH - len(indent) - 3)
    return [
        f"{indent}/*",
        *(f"{indent} * {line}".rstrip() for line in inside),
        f"{indent} */",
    ]


def _reflowed(lines: list[str], room: int) -> list[str]:
    """Return lines that fit into the room: paragraphs with one that does not are wrapped anew."""
    reflowed: list[str] = []
    paragraph: list[str] = []
    for line in [*lines, ""]:
        if line.strip() and (not paragraph or _continues(paragraph[-1], line)):
            paragraph.append(line)
            continue
        reflowed += _wrapped(paragraph, room)
        paragraph = [line] if line.strip() else []
        if not line.strip():
            reflowed.append("")
    return reflowed[:-1]


def _continues(above: str, line: str) -> bool:
    """Tell whether a line belongs to the sentence of the one above, not to a list or a formula."""
    return not line.startswith((" ", "* ")) or (above.startswith("* ") and line.startswith("  "))


def _wrapped(lines: list[str], room: int) -> list[str]:
    if all(len(line) <= room for line in lines):
        return lines
    indent = "  " if lines[0].startswith("* ") else " " * (len(lines[0]) - len(lines[0].lstrip()))
    first = indent if lines[0].startswith(" ") else ""
    text = " ".join(line.strip() for line in lines)
    return textwrap.wrap(text, room, initial_indent=first, subsequent_indent=indent)


def heading(module: str, docstring: str) -> list[str]:
    """Return a comment between sections: a module's path, and what its docstring has."""
    path = module.replace("motionlab.", "", 1).replace(".", "/") + ".py"
    line = f"/* -- {path} "
    return [line + "-" * (WIDTH - len(line) - 3) + " */", "", *comment(docstring), ""]
