"""All views; endpoints and ``motionlab view`` offer what is listed here."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from motionlab.declarations import DeclarationError
from motionlab.errors import ConfigError, FieldError
from motionlab.own_files import OwnFile
from motionlab.own_studies import (
    check_document,
    check_model,
    check_name,
    declared,
    module_of,
    note,
    placed,
    wrong,
)

COLUMNS_MAX = 200
"""Most columns that a view of one's own may reserve."""

if TYPE_CHECKING:
    from pydantic import BaseModel

    from motionlab.analysis.views.recorded import Recorded
    from motionlab.config.scenario import Scenario


class View(NamedTuple):
    """A view, computed by the module of its name beside this one.

    That module has a function of the view's name, from `Recorded` to a document. A view with
    options has a model of them, which its function takes too, and may have ``measured_scenario``,
    from a scenario and options to the scenario that is simulated in its place, whole. Modules are
    imported on use, so that ``motionlab --help`` answers at once.

    Attributes
    ----------
    name : str
        Of the endpoint, the command, the module and the function.
    document_name : str
        Of the class of its document.
    summary : str
        What it returns, one sentence.
    window : bool
        Whether its stretch is the window of the metrics where none is given, or everything.
    columns : int
        Most columns in memory at once.
    options_name : str
        Of the class of its options; empty where it has none.
    file : OwnFile or None
        Of a view of one's own, in place of the module beside this one.
    """

    name: str
    document_name: str
    summary: str
    window: bool = True
    columns: int = 24
    options_name: str = ""
    file: OwnFile | None = None

    def compute(self, recorded: Recorded, options: BaseModel | None = None) -> BaseModel:
        """Return the document of a recording; `options` where the view has some."""
        of = self._own(self.name)
        arguments = (recorded, options) if self.options_name else (recorded,)
        if self.file is None:
            return of(*arguments)
        document = placed(self.file, of)(*arguments)
        return check_document(self.file, self.name, document, self.document)

    @property
    def document(self) -> type[BaseModel]:
        """Class of the document."""
        return self._own(self.document_name)

    @property
    def options(self) -> type[BaseModel] | None:
        """Class of its options."""
        return self._own(self.options_name) if self.options_name else None

    @property
    def measures(self) -> bool:
        """Whether it simulates a scenario of its own, whole, in place of the one that it is of."""
        return hasattr(self._module, "measured_scenario")

    def to_simulate(
        self, scenario: Scenario, options: BaseModel | None, stretch: Mapping[str, float | None]
    ) -> Scenario:
        """Return the scenario that is simulated for a view of a scenario.

        Raises
        ------
        ConfigError
            If a time of `stretch`, by the name of its field, is set where the view is of the whole.
        """
        if not self.measures:
            return scenario
        for name, time in stretch.items():
            if time is not None:
                message = f"is of a run; {self.name} of a scenario is measured whole"
                raise ConfigError(FieldError(name, message, time, unit="s"))
        measured = self._own("measured_scenario")
        if self.file is not None:
            measured = placed(self.file, measured)
        return measured(scenario, options)

    @property
    def _module(self) -> Any:
        if self.file is not None:
            return module_of(self.file)
        return importlib.import_module(f"motionlab.analysis.views.{self.name}")

    def _own(self, name: str) -> Any:
        return getattr(self._module, name)


SHIPPED: tuple[View, ...] = (
    View("ballbar", "Ballbar", "Circular test, radial deviation in both directions", False, 24),
    View("contouring", "Contouring", "Contour error beside tracking error", True, 48),
    View("cost", "Cost", "Energy, currents and forces of each variant beside the first", True, 24),
    View("friction", "FrictionAnatomy", "Friction: true, estimated and compensated", True, 20),
    View(
        "positioning",
        "Positioning",
        "Accuracy and repeatability at targets, ISO 230-2 style",
        False,
        8,
        "PositioningCycle",
    ),
)


def _own() -> tuple[View, ...]:
    """Return the views of one's own that can be taken, and note why others cannot."""
    views: list[View] = []
    for view, file in declared("VIEW"):
        try:
            views.append(_checked(view, file, frozenset(each.name for each in (*SHIPPED, *views))))
        except DeclarationError as error:
            note(error, file)
    return tuple(views)


def _checked(view: Any, file: OwnFile, taken: frozenset[str]) -> View:
    if not isinstance(view, View):
        raise wrong(file, "VIEW", "is no motionlab.analysis.views.table.View")
    check_name(file, "VIEW.name", view.name, taken, "_")
    if not isinstance(view.summary, str) or not view.summary:
        raise wrong(file, "VIEW.summary", "is no sentence", view.summary)
    module = module_of(file)
    if not callable(getattr(module, view.name, None)):
        raise wrong(file, view.name, "is no function of this file")
    for field, name in (("document_name", view.document_name), ("options_name", view.options_name)):
        if name or field == "document_name":
            check_model(file, f"VIEW.{field}", getattr(module, name, None))
    if not isinstance(view.columns, int) or not 1 <= view.columns <= COLUMNS_MAX:
        raise wrong(file, "VIEW.columns", "is out of range", view.columns, f"1 to {COLUMNS_MAX}")
    return view._replace(file=file)


VIEWS: tuple[View, ...] = (*SHIPPED, *_own())
BY_NAME: dict[str, View] = {view.name: view for view in VIEWS}
