"""One recorded function as C: what is left of its statements, where each variable is declared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from motionlab.targets.c_liveness import Liveness
from motionlab.targets.c_variables import Repeated, copy_moving_aliases, separate_old_values
from motionlab.targets.c_words import free_name, safe
from motionlab.targets.record_statements import (
    Assignment,
    CallStatement,
    Carried,
    Loop,
    RecordedFunction,
    Return,
    Statement,
    assigned,
    walk,
)
from motionlab.targets.record_structures import snake
from motionlab.targets.record_values import (
    Call,
    Expression,
    Read,
    Structure,
    Variable,
    operands_of,
)


class LiveFunction:
    """A recorded function without what is not needed.

    Attributes
    ----------
    parameters : list of Variable
        That it reads.
    outputs : list of Variable
        Of several needed results; a single one is returned.
    body : list of Statement
        With a variable for each expression that is used twice.
    result_name : str
        Of a variable for a structure that is returned.
    renamed : dict
        Names of values that replace one which is still read.
    """

    def __init__(self, function: RecordedFunction, live: Liveness) -> None:
        self.function, self._live = function, live
        self.parameters = [p for p in function.parameters if live.has_parameter(function, p)]
        self.places = live_places(function, live)
        several = len(self.places) > 1
        self.outputs = [function.outputs[place] for place in self.places] if several else []
        self.renamed: dict[tuple[Variable, int], str] = {}
        self._taken = function.names | {output.name for output in function.outputs}
        self.body = self._block(function.body)
        repeated = Repeated(self)
        self._hoisted = repeated.held
        self.body = repeated.body(self.body)
        copy_moving_aliases(self)
        separate_old_values(self)
        result = self.result()
        made = isinstance(result, Structure)
        self.result_name = self.new_name(snake(result.kind)) if made else ""

    def hoisted(self, value: Expression) -> Read | None:
        """Return the variable that holds an expression, if there is one."""
        return self._hoisted.get(id(value))

    def name(self, variable: Variable, version: int) -> str:
        """Return the name of a variable after so many assignments."""
        return safe(self.renamed.get((variable, version), variable.name))

    def assignments(self, variable: Variable, name: str = "") -> int:
        """Return how often a variable is assigned, under a name if one is given.

        Those of loops count twice.
        """
        direct = sum(
            each is variable and (not name or self.name(each, version) == name)
            for statement in walk(self.body)
            for each, version in assigned(statement)
        )
        return direct + sum(each.variable is variable for each in self.carried())

    def result(self) -> Expression | None:
        """Return the one value that the function returns, if it does not have outputs."""
        last = self.function.body[-1]
        assert isinstance(last, Return)
        return None if self.outputs else last.values[self.places[0]]

    def returned(self) -> list[Expression]:
        """Return the values of the outputs."""
        last = self.function.body[-1]
        assert isinstance(last, Return)
        return [last.values[place] for place in self.places]

    def arguments(self, call: Call | CallStatement) -> list[Expression]:
        """Return the arguments of a call that the called function takes."""
        return arguments_of(call.function, call.arguments, self._live)

    def targets(self, statement: CallStatement) -> list[Read]:
        """Return the variables that a call gives a value."""
        return [statement.targets[place] for place in live_places(statement.function, self._live)]

    def fields(self, value: Structure) -> dict[str, Expression]:
        """Return the fields of a structure that somebody reads."""
        return {
            name: each
            for name, each in value.fields.items()
            if self._live.has_field(value.kind, name)
        }

    @property
    def names(self) -> set[str]:
        """Names of its variables."""
        return self._taken

    def new_name(self, label: str) -> str:
        """Return a name that nothing else in the function has."""
        name = free_name(label, self._taken)
        self._taken.add(name)
        return name

    # -- what is needed --

    def _block(self, body: Sequence[Statement]) -> list[Statement]:
        kept: list[Statement] = []
        for statement in body:
            match statement:
                case Assignment(variable, version) if self._live.has_value(variable, version):
                    kept.append(statement)
                case CallStatement() if self._live.has_call(statement):
                    kept.append(statement)
                case Loop(count, line, carried):
                    inside = self._block(statement.body)
                    if inside:
                        kept.append(Loop(count, line, carried, inside))
                case Return():
                    kept.append(statement)
                case _:
                    pass
        return kept

    def carried(self) -> Iterator[Carried]:
        """Yield the variables of loops."""
        for statement in walk(self.body):
            if isinstance(statement, Loop):
                yield from statement.carried

    def roots(self, statement: Statement) -> list[Expression]:
        """Return the expressions that a statement computes."""
        match statement:
            case Assignment(_, _, value):
                return [value]
            case CallStatement():
                return self.arguments(statement)
            case Return():
                return self.returned()
            case Loop(count):
                return [count]

    def operands(self, value: Expression) -> list[Expression]:
        """Return what of an expression's operands is needed."""
        match value:
            case Call():
                return self.arguments(value)
            case Structure():
                return list(self.fields(value).values())
            case _:
                return list(operands_of(value))


def live_places(function: RecordedFunction, live: Liveness) -> list[int]:
    """Return which of a function's results somebody needs."""
    places = range(max(len(function.outputs), 1))
    return [place for place in places if not function.outputs or live.has_output(function, place)]


def arguments_of(function: RecordedFunction, arguments: Any, live: Liveness) -> list[Expression]:
    """Return the arguments of a function that it reads, in their order."""
    return [arguments[each] for each in function.parameters if live.has_parameter(function, each)]
