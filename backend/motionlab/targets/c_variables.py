"""Variables that C needs and Python does not: for what is used twice, and for old values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from motionlab.targets.record_statements import (
    Assignment,
    CallStatement,
    Loop,
    Statement,
    assigned,
    walk,
)
from motionlab.targets.record_structures import snake
from motionlab.targets.record_values import (
    Call,
    Choice,
    Element,
    Expression,
    Four,
    Library,
    Member,
    Operation,
    Read,
    RecordError,
    Structure,
    Variable,
    value_of,
)

if TYPE_CHECKING:
    from motionlab.targets.c_function import LiveFunction

_COMPUTED = (Operation, Choice, Library, Call, Structure, Four)


class Repeated:
    """Gives a variable to each expression that is used twice, or whose address is needed."""

    def __init__(self, function: LiveFunction) -> None:
        self._function = function
        self._uses: Counter[int] = Counter()
        self._addressed: set[int] = set()
        self.held: dict[int, Read] = {}
        for statement in walk(function.body):
            for root in function.roots(statement):
                self._count(root)
            if isinstance(statement, CallStatement):
                self._address(function.arguments(statement))

    def body(self, body: Sequence[Statement]) -> list[Statement]:
        """Return a block with the assignments to those variables."""
        result: list[Statement] = []
        for statement in body:
            assigns = isinstance(statement, Assignment)
            for root in self._function.roots(statement):
                for value in self._repeated(root, assigned=assigns):
                    variable = Variable(self._function.new_name(_label(value)), value.kind)
                    variable.pointer = isinstance(value, Four)
                    self.held[id(value)] = Read(variable)
                    result.append(Assignment(variable, 0, value, statement.line))
            if isinstance(statement, Loop):
                statement.body = self.body(statement.body)
            result.append(statement)
        return result

    def _count(self, value: Expression) -> None:
        self._uses[id(value)] += 1
        if self._uses[id(value)] > 1:
            return
        if isinstance(value, Call):
            self._address(self._function.arguments(value))
        if isinstance(value, (Member, Element)) and isinstance(value.base, (Call, Four)):
            self._addressed.add(id(value.base))
        for each in self._function.operands(value):
            self._count(each)

    def _address(self, arguments: Sequence[Expression]) -> None:
        """Note the arguments that are structures and have no address yet."""
        self._addressed |= {
            id(each)
            for each in arguments
            if hasattr(each.kind, "_fields") and isinstance(each, (Call, Structure))
        }

    def _repeated(self, value: Expression, *, assigned: bool) -> Iterator[Expression]:
        """Yield what is to be held by a variable, operands first."""
        if id(value) in self.held:
            return
        for each in self._function.operands(value):
            yield from self._repeated(each, assigned=False)
        if not isinstance(value, _COMPUTED) or value_of(value) is not None:
            return
        repeated = self._uses[id(value)] > 1 and not isinstance(value, Structure)
        if id(value) not in self.held and (
            id(value) in self._addressed or (repeated and not assigned)
        ):
            yield value


def _label(value: Expression) -> str:
    match value:
        case Call(function) if function.source.name.endswith("_of"):
            return function.source.name.removesuffix("_of").lstrip("_")
        case Call(kind=kind) | Structure(kind=kind) if hasattr(kind, "_fields"):
            return snake(kind)
        case Four():
            return "four"
        case _:
            return "term"


def copy_moving_aliases(function: LiveFunction) -> None:
    """Copy a structure, in place of referring to it, where it is assigned anew later."""
    for statement in walk(function.body):
        if isinstance(statement, Assignment) and statement.variable.pointer:
            root = statement.value
            while isinstance(root, Member):
                root = root.base
            if isinstance(root, Read) and not root.variable.pointer:
                statement.variable.pointer = function.assignments(root.variable) <= 1


def separate_old_values(function: LiveFunction) -> None:
    """Give a variable of its own to a value that replaces one which is still read.

    Raises
    ------
    RecordError
        If a loop would have to do so.
    """
    while (stale := _stale(function)) is not None:
        variable, version = stale
        if any(each.variable is variable for each in function.carried()):
            raise RecordError(
                f"{function.function.source.name}: the value that {variable.name} had before its "
                "assignment in a loop is read after it; give it a name of its own"
            )
        name = function.new_name(variable.name)
        for later in range(version, variable.versions):
            function.renamed[variable, later] = name


def _stale(function: LiveFunction) -> tuple[Variable, int] | None:
    """Return a variable that is read after its next value, of which version, is there."""
    current: dict[str, tuple[Variable, int]] = {}
    for statement in walk(function.body):
        for root in function.roots(statement):
            for variable, version in _reads(function, root):
                name = function.name(variable, version)
                there, newer = current.get(name, (variable, version))
                if there is variable and newer > version:
                    return variable, newer
        if isinstance(statement, Loop):
            for each in statement.carried:
                current[function.name(each.variable, each.within)] = (each.variable, each.within)
        for variable, version in assigned(statement):
            current[function.name(variable, version)] = (variable, version)
    return None


def _reads(function: LiveFunction, value: Expression) -> Iterator[tuple[Variable, int]]:
    if function.hoisted(value) is not None:
        return
    if isinstance(value, Read):
        yield value.variable, value.version
    for each in function.operands(value):
        yield from _reads(function, each)
