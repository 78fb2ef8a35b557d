"""What a study found: its document, its report, and its rows as a table."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pydantic import BaseModel

from motionlab.errors import naming_extras
from motionlab.files import check_target, complete_file
from motionlab.reports.markup import element
from motionlab.scripting.channels import in_notebook
from motionlab.studies.study import Study
from motionlab.studies.sweep.report import case_values

if TYPE_CHECKING:
    import pandas as pd

    from motionlab.studies.identify.documents import IdentificationDocument
    from motionlab.studies.montecarlo.documents import MonteCarloDocument
    from motionlab.studies.sensitivity.documents import SensitivityDocument
    from motionlab.studies.sweep.documents import SweepDocument
    from motionlab.studies.tune.documents import TuneDocument

Document = TypeVar("Document", bound=BaseModel)
Row = dict[str, Any]


@dataclasses.dataclass(frozen=True)
class StudyResult(Generic[Document]):
    """Result of a study; ``str(result)`` is the report that its command prints.

    Attributes
    ----------
    study : Study
        Which one.
    document : BaseModel
        All that it found, as its command prints it with ``--json``.
    """

    study: Study
    document: Document

    @property
    def set(self) -> dict[str, Any]:
        """What puts gains or a friction model that were found into the scenario, by dotted path.

        Raises
        ------
        AttributeError
            Of a study that proposes none.
        """
        return getattr(self.document, "set")  # noqa: B009 - of some documents only

    def rows(self) -> list[Row]:
        """Return one mapping a case, field, candidate or point, SI.

        Of sweep, montecarlo, sensitivity, tune and identify; of `montecarlo` with every metric and
        every drawn number.

        Raises
        ------
        AttributeError
            Of a study without rows.
        """
        if self.study.kind not in _ROWS:
            raise AttributeError(f"the document of {self.study.kind} has no rows")
        return list(_ROWS[self.study.kind](self.document))

    @naming_extras("to_pandas")
    def to_pandas(self) -> pd.DataFrame:
        """Return `rows` as a data frame.

        Raises
        ------
        NotInstalled
            If pandas is not installed.
        """
        import pandas as pd

        return pd.DataFrame(self.rows())

    def save(self, path: str | Path) -> Path:
        """Write the document as ``.json``, or the file that ``--out`` of the command writes.

        Raises
        ------
        ConfigError
            If the file has another ending, or cannot be there.
        StoreError
            If it cannot be written.
        """
        endings = dict.fromkeys((".json", *self.study.suffixes))
        check_target(str(path), *endings, loc="path")
        if Path(path).suffix in self.study.suffixes:
            self.study.write(self.document, str(path))
        else:
            with complete_file(str(path)) as partial:
                partial.write_text(self.study.text(self.document), encoding="utf-8")
        return Path(path)

    def __str__(self) -> str:
        """Return the report."""
        return self.study.report(self.document)

    def __repr__(self) -> str:
        """Return a line about the result."""
        return f"<Result of {self.study.kind}: {', '.join(type(self.document).model_fields)}>"

    def _repr_html_(self) -> str:
        return in_notebook(element("pre", str(self)))


def _of_sweep(document: SweepDocument) -> Iterator[Row]:
    paths = [field.path for field in document.fields]
    columns = {
        f"{name}.{axis}.{key}": values
        for name, variant in document.variants.items()
        for axis, swept in variant.axes.items()
        for key, values in swept.metrics.items()
    }
    for case, values in enumerate(case_values(document)):
        row: Row = {"case": case, **dict(zip(paths, values, strict=True))}
        yield row | {name: column[case] for name, column in columns.items()}


def _of_sensitivity(document: SensitivityDocument) -> Iterator[Row]:
    for index, field in enumerate(document.fields):
        slopes = {
            f"{name}.{axis}.{metric}": effect.slope[index]
            for name, axes in document.variants.items()
            for axis, metrics in axes.items()
            for metric, effect in metrics.items()
        }
        yield {**field.model_dump(), **slopes}


def _of_tuning(document: TuneDocument) -> Iterator[Row]:
    for group in document.groups:
        for one in (group.present, group.paper, *group.candidates):
            row: Row = {"origin": one.origin, "cost": one.cost, "feasible": one.feasible}
            yield (
                row
                | {f"{a}.k_p": g.k_p for a, g in one.axes.items()}
                | {f"{a}.k_d": g.k_d for a, g in one.axes.items()}
                | one.also
            )


def _of_cases(document: MonteCarloDocument) -> Iterator[Row]:
    columns = document.table or {
        f"{name}.{axis}.max_abs_following_error": each.peaks
        for name, variant in document.variants.items()
        for axis, each in variant.axes.items()
    }
    for case in range(document.cases):
        yield {"case": case, **{name: values[case] for name, values in columns.items()}}


def _of_points(document: IdentificationDocument) -> Iterator[Row]:
    for axis, each in document.axes.items():
        for point, residual in zip(each.points, each.residuals, strict=True):
            yield {"axis": axis, **point.model_dump(), "residual": residual}


_ROWS: dict[str, Any] = {
    "sweep": _of_sweep,
    "sensitivity": _of_sensitivity,
    "tune": _of_tuning,
    "monte-carlo": _of_cases,
    "identify": _of_points,
}
