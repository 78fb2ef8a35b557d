"""What a request of a study of one's own begins with."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from motionlab.config.quantity import Config


class ScenarioRequest(Config):
    """A scenario, and changes of it."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
