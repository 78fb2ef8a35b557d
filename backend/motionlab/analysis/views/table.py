"""All views; endpoints and ``motionlab view`` offer what is listed here."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from motionlab.errors import ConfigError, FieldError

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
    """

    name: str
    document_name: str
    summary: str
    window: bool
    columns: int
    options_name: str = ""

    def compute(self, recorded: Recorded, options: BaseModel | None = None) -> BaseModel:
        """Return the document of a recording; `options` where the view has some."""
        of = self._own(self.name)
        return of(recorded, options) if self.options_name else of(recorded)

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
        return self._own("measured_scenario")(scenario, options)

    @property
    def _module(self) -> Any:
        return importlib.import_module(f"motionlab.analysis.views.{self.name}")

    def _own(self, name: str) -> Any:
        return getattr(self._module, name)


VIEWS: tuple[View, ...] = (
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
BY_NAME: dict[str, View] = {view.name: view for view in VIEWS}
