"""What a link tells of itself: its fault, its drives, the parameters in effect."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from pydantic import BaseModel, Field

from motionlab.drive.process_data import drive_state


class FaultNow(BaseModel):
    """A latched fault."""

    code: int
    error: int = Field(description="Error code 603F of a drive that failed; else 0")
    name: str
    subject: Literal["link", "drive", "axis"]
    place: int = Field(description="Drive from 1, or axis from 1; 0 for the link")
    value: float | None = Field(description="What was found, in `unit`; null without a figure")
    limit: float | None = Field(description="What is allowed, in `unit`")
    unit: str
    remedy: str


class Loaded(NamedTuple):
    """A set of parameters in effect: its number, and the first tick of the present motion."""

    number: int
    tick: int


@dataclass(frozen=True)
class DriveNow:
    """One drive at the moment."""

    status_word: int
    error: int
    torque: int  # per mille of rated

    @property
    def state(self) -> str:
        """Its state in the words of CiA 402."""
        return drive_state(self.status_word)
