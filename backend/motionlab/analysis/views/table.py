"""All views; endpoints, ``motionlab view`` and the page offer what is listed here.

Beside them there is `motionlab.analysis.views.positioning`, whose request has fields of its own.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pydantic import BaseModel

    from motionlab.analysis.views.recorded import Recorded


class View(NamedTuple):
    """A view, computed by the module of its name beside this one.

    That module has a function of the view's name, from `Recorded` to a document, and ``report``,
    from that to lines of text. It is imported on use, so that ``motionlab --help`` answers at once.

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
    """

    name: str
    document_name: str
    summary: str
    window: bool
    columns: int

    @property
    def compute(self) -> Callable[[Recorded], BaseModel]:
        """Return the document of a recording."""
        return self._own(self.name)

    @property
    def report(self) -> Callable[[Any], list[str]]:
        """Return a document as lines of text."""
        return self._own("report")

    @property
    def document(self) -> type[BaseModel]:
        """Class of the document."""
        return self._own(self.document_name)

    def _own(self, name: str) -> Any:
        return getattr(importlib.import_module(f"motionlab.analysis.views.{self.name}"), name)


VIEWS: tuple[View, ...] = (
    View("ballbar", "Ballbar", "Circular test, radial deviation in both directions", False, 24),
    View("contouring", "Contouring", "Contour error beside tracking error", True, 48),
    View("cost", "Cost", "Energy, currents and forces of each variant beside the first", True, 24),
    View("friction", "FrictionAnatomy", "Friction: true, estimated and compensated", True, 20),
)
BY_NAME: dict[str, View] = {view.name: view for view in VIEWS}
