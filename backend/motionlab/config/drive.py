"""Configuration of a drive link: the bus, six current drives, two encoders, limits."""

from __future__ import annotations

import itertools
import re
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationError, model_validator

from motionlab.config.bounds import FILE_MAX, check_depth, check_toml
from motionlab.config.named_configs import config_root
from motionlab.config.planar import AXES
from motionlab.config.quantity import Config, Whole, quantity
from motionlab.config.validation_errors import field_errors
from motionlab.declarations import OURS
from motionlab.errors import ConfigError, FieldError

PHASES = ("a", "b", "c")
LAYOUT = tuple(itertools.product(AXES, PHASES))
"""Axis and phase of every drive."""

_COUNTS = 2**31
_NAME = re.compile(r"[a-z0-9-]+")
_IDENTITY_MAX = 0xFFFF_FFFF


class LinkConfig(Config):
    """The bus and its timing."""

    carrier: Literal["udp", "ethernet"] = Field(
        default="udp",
        description="EtherCAT in UDP packets, for the virtual drive, or on a network card",
    )
    address: str = Field(
        default="127.0.0.1",
        description="IP address of the segment, with carrier udp",
        pattern=r"^[0-9A-Fa-f.:]{2,45}$",
    )
    port: Whole = Field(default=34980, ge=1, le=65535, description="UDP port of the segment")
    interface: str = Field(
        default="",
        description="Name of the network card, with carrier ethernet",
        pattern=r"^[A-Za-z0-9_.:-]{0,15}$",
    )
    distributed_clocks: bool = Field(
        default=True, description="Whether drives act at SYNC0 of their common clock"
    )
    sync_shift: float = quantity(
        "Time from SYNC0 to the exchange of process data",
        shown="\u00b5s",
        unit="s",
        source=OURS,
        default=100e-6,
        ge=0.0,
        le=400e-6,
    )
    watchdog: float = quantity(
        "Time without process data after which a drive de-energises itself",
        shown="ms",
        unit="s",
        source=OURS,
        default=0.020,
        ge=0.002,
        le=0.1,
    )
    loss: float = quantity(
        "Time without process data after which the link stops and latches a fault",
        shown="ms",
        unit="s",
        source=OURS,
        default=0.010,
        ge=0.001,
        le=0.05,
    )
    priority: Whole = Field(
        default=80, ge=0, le=98, description="Priority under SCHED_FIFO; 0 does without"
    )
    slow: Whole = Field(
        default=1,
        ge=1,
        le=20,
        description="How many times slower than real time loop and virtual drive run; 1 for drives",
    )

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        if self.carrier == "ethernet" and not self.interface:
            raise ValueError("carrier ethernet needs the name of a network card in interface")
        if self.loss >= self.watchdog:
            raise ValueError(
                f"loss = {self.loss:g} s must be below watchdog = {self.watchdog:g} s: "
                "the link stops before the drives do"
            )
        return self


class NodeConfig(Config):
    """One drive, in the order of the segment."""

    axis: Literal["x", "y"]
    phase: Literal["a", "b", "c"]
    vendor: Whole = Field(ge=0, le=_IDENTITY_MAX, description="Vendor, object 1018:01")
    product: Whole = Field(ge=0, le=_IDENTITY_MAX, description="Product code, object 1018:02")
    rated_current: float = quantity(
        "Rated current, object 6075: a thousandth of it is the step of a command",
        unit="A",
        source=OURS,
        default=10.0,
        gt=0.0,
        le=100.0,
    )
    sync_shift: float = quantity(
        "SYNC0 of this drive after that of the first",
        shown="\u00b5s",
        unit="s",
        source=OURS,
        default=0.0,
        ge=0.0,
        le=250e-6,
    )


class DriveAxisConfig(Config):
    """Encoder and limits of one axis."""

    encoder: Whole = Field(ge=1, le=6, description="Drive that reads the encoder, from 1")
    resolution: float = quantity(
        "Size of one count", shown="nm", unit="m", source=OURS, gt=0.0, le=1e-4
    )
    direction: Literal[1, -1] = Field(
        default=1, description="-1 where counts fall towards positive positions"
    )
    offset: float = quantity(
        "Position at count 0",
        shown="mm",
        unit="m",
        source="found by homing",
        default=0.0,
        ge=-1.0,
        le=1.0,
    )
    position_min: float = quantity(
        "Least position, object 607D:01", shown="mm", unit="m", source=OURS, ge=-1.0, le=1.0
    )
    position_max: float = quantity(
        "Largest position, object 607D:02", shown="mm", unit="m", source=OURS, ge=-1.0, le=1.0
    )
    velocity_max: float = quantity(
        "Largest speed", shown="mm/s", unit="m/s", source=OURS, gt=0.0, le=5.0
    )
    deceleration: float = quantity(
        "Deceleration of a controlled stop", unit="m/s^2", source=OURS, gt=0.0, le=100.0
    )
    following_error: float = quantity(
        "Following error window, object 6065",
        shown="\u00b5m",
        unit="m",
        source=OURS,
        gt=0.0,
        le=0.1,
    )
    following_error_time: float = quantity(
        "Time outside the window before a fault, object 6066",
        shown="ms",
        unit="s",
        source=OURS,
        default=0.010,
        ge=0.0,
        le=1.0,
    )
    current_max: float = quantity(
        "Largest current of a phase, object 6073", unit="A", source=OURS, gt=0.0, le=100.0
    )

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if self.position_min >= self.position_max:
            raise ValueError(
                f"position_min = {self.position_min:g} m is not below "
                f"position_max = {self.position_max:g} m"
            )
        far = max(abs(self.position_min - self.offset), abs(self.position_max - self.offset))
        if far / self.resolution >= _COUNTS:
            raise ValueError(
                f"resolution = {self.resolution:g} m: {far:g} m from count 0 to a limit of "
                f"position are beyond the {_COUNTS} counts of a drive"
            )
        return self


class DriveConfig(Config):
    """Six current drives and two encoders behind one EtherCAT master."""

    title: str = Field(max_length=200)
    description: str = Field(default="", max_length=2000)
    virtual: bool = Field(
        default=False, description="Whether a virtual drive answers: nothing can move for real"
    )
    link: LinkConfig = Field(default_factory=LinkConfig)
    nodes: Annotated[tuple[NodeConfig, ...], Field(strict=False)] = Field(
        min_length=6, max_length=6, description="The drives in the order of the segment"
    )
    x: DriveAxisConfig
    y: DriveAxisConfig

    @model_validator(mode="after")
    def _has_every_phase_once(self) -> Self:
        counts = Counter((node.axis, node.phase) for node in self.nodes)
        twice = [f"{axis} {phase}" for (axis, phase), count in counts.items() if count > 1]
        if twice:
            missing = [f"{axis} {phase}" for axis, phase in LAYOUT if not counts[axis, phase]]
            raise ValueError(
                f"more than one drive for {', '.join(twice)}, none for {', '.join(missing)}"
            )
        return self

    @model_validator(mode="after")
    def _has_encoders_of_their_axes(self) -> Self:
        for axis in AXES:
            encoder = getattr(self, axis).encoder
            node = self.nodes[encoder - 1]
            if node.axis != axis:
                raise ValueError(
                    f"{axis}.encoder = {encoder} is drive {node.axis} {node.phase}: the encoder of "
                    "an axis is read by one of its own drives, which holds its limits of position"
                )
        return self

    @model_validator(mode="after")
    def _is_slow_with_a_virtual_drive_only(self) -> Self:
        if self.link.slow > 1 and not self.virtual:
            raise ValueError(
                f"link.slow = {self.link.slow}: drives run in real time; only a virtual one, with "
                "virtual = true, can be slower"
            )
        return self

    @model_validator(mode="after")
    def _currents_are_within_ratings(self) -> Self:
        for node in self.nodes:
            limit = getattr(self, node.axis).current_max
            if limit > 2 * node.rated_current:
                raise ValueError(
                    f"{node.axis}.current_max = {limit:g} A is more than twice the rated current "
                    f"of drive {node.axis} {node.phase}, {node.rated_current:g} A"
                )
        return self

    def place(self, axis: str, phase: str) -> int:
        """Return the index of a drive in the segment."""
        return next(
            i for i, node in enumerate(self.nodes) if (node.axis, node.phase) == (axis, phase)
        )


def load_drive(name: Path | str) -> DriveConfig:
    """Return the drive link that a TOML file describes, or a shipped one by its name.

    Raises
    ------
    ConfigError
        If it cannot be read; naming every field that is wrong, its value, range and unit.
    """
    shipped = config_root() / "drives" / f"{name}.toml"
    path = Path(name)
    try:
        if _NAME.fullmatch(str(name)) and shipped.is_file():
            path = shipped
        with path.open("rb") as file:
            text = file.read(FILE_MAX + 1).decode()
        if len(text) > FILE_MAX:
            raise ConfigError(FieldError(loc="drive", message=f"{path} is too long"))
        check_toml(text, loc="drive")
        document = tomllib.loads(text)
        check_depth(document, loc="drive")
        return DriveConfig.model_validate(document)
    except OSError as error:
        raise ConfigError(FieldError("drive", f"{path}: {error.strerror}")) from None
    except ValidationError as error:
        problems = field_errors(error, DriveConfig)
        raise ConfigError(*(replace(each, loc=each.loc or "drive") for each in problems)) from None
    except ValueError as error:  # no UTF-8, no TOML, or a whole number of thousands of digits
        raise ConfigError(FieldError("drive", f"{path} is no TOML: {error}")) from None
