"""Document of a session's metrics."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from motionlab.analysis.result_document import AxisComparison, VariantMetrics, Window


class SessionMetrics(BaseModel):
    """Metrics of a session's latest past; no variants before its first tick."""

    model_config = ConfigDict(extra="forbid")

    window: Window
    variants: dict[str, VariantMetrics]
    comparison: dict[str, AxisComparison]  # pyright: ignore[reportInvalidTypeForm]
