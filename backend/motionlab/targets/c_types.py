"""NamedTuple classes as C structures, with the comments of their declarations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, get_type_hints

from motionlab.declarations import field_comments
from motionlab.targets.c_comments import comment, inside_comment
from motionlab.targets.c_expression import INDENT, WIDTH
from motionlab.targets.c_function import LiveFunction
from motionlab.targets.c_liveness import Liveness
from motionlab.targets.c_words import ascii_name, free_name, safe
from motionlab.targets.record_statements import Assignment, walk
from motionlab.targets.record_structures import snake


class Types:
    """Structures of a program.

    Parameters
    ----------
    live : Liveness
        Of their fields.
    prefix : str
        Of their names.
    names : mapping, optional
        Names of some, by class.
    taken : iterable of str
        Names that no other structure has.
    """

    def __init__(
        self,
        live: Liveness,
        *,
        prefix: str,
        names: Mapping[Any, str] | None = None,
        taken: Iterable[str] = (),
    ) -> None:
        self._live, self._prefix = live, prefix
        self._names: dict[Any, str] = dict(names or {})
        self._taken = {*taken, *self._names.values()}

    def name(self, kind: Any) -> str:
        """Return the name of a structure."""
        if kind not in self._names:
            label = ascii_name(snake(kind))
            name = self._prefix + label
            if name in self._taken:
                package = kind.__module__.rpartition(".")[0].rpartition(".")[2]
                name = free_name(f"{self._prefix}{package}_{label}", self._taken)
            self._names[kind] = name
            self._taken.add(name)
        return self._names[kind]

    def fields(self, kind: Any) -> list[str]:
        """Return the fields of a NamedTuple class that are read."""
        return [name for name in kind._fields if self._live.has_field(kind, name)]

    def code(
        self, entries: Iterable[LiveFunction], functions: Iterable[LiveFunction], *, public: bool
    ) -> str:
        """Return the structures in parameters and results of entries, or all other ones."""
        outside: dict[Any, None] = {}
        for function in entries:
            for kind in _signature_kinds(function):
                self._add(kind, outside)
        kinds = dict(outside)
        for function in functions:
            for kind in [*_signature_kinds(function), *_local_kinds(function)]:
                self._add(kind, kinds)
        chosen = [kind for kind in kinds if (kind in outside) == public]
        return "\n".join(line for kind in chosen for line in [*self._definition(kind), ""])

    def _add(self, kind: Any, kinds: dict[Any, None]) -> None:
        """Add a structure after those in it."""
        if hasattr(kind, "_fields") and kind not in kinds:
            for inner in self._inner(kind).values():
                self._add(inner, kinds)
            kinds[kind] = None

    def _inner(self, kind: Any) -> dict[str, Any]:
        """Return the fields that are structures themselves, with their class."""
        hints = get_type_hints(kind)
        fields = self.fields(kind)
        return {name: hints[name] for name in fields if hasattr(hints[name], "_fields")}

    def _definition(self, kind: Any) -> Iterator[str]:
        inner, comments = self._inner(kind), field_comments(kind)
        members: list[tuple[str, str]] = []
        for name in self.fields(kind):
            plain = "bool" if "Mask" in str(kind.__annotations__[name]) else "double"
            type_name = self.name(inner[name]) if name in inner else plain
            about = inside_comment(comments.get(name, ""))
            members.append((f"{INDENT}{type_name} {safe(name)};", about))
        yield from comment(kind.__doc__ or "")
        yield "typedef struct {"
        width = max((len(member) for member, about in members if about), default=0)
        for member, about in members:
            text = f"{member:<{width}} /* {about} */"
            if about and len(text) > WIDTH:
                yield f"{INDENT}/* {about} */"
                yield member
            else:
                yield text if about else member
        yield f"}} {self.name(kind)};"


def _signature_kinds(function: LiveFunction) -> list[Any]:
    kinds = [each.kind for each in [*function.parameters, *function.outputs]]
    result = function.result()
    return kinds if result is None else [*kinds, result.kind]


def _local_kinds(function: LiveFunction) -> list[Any]:
    return [each.variable.kind for each in walk(function.body) if isinstance(each, Assignment)]
