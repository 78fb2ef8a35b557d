"""Messages between the web process and a 3-D view's process, through a pipe.

A message is a kind, one byte, a length, uint32 little-endian, and so many bytes: JSON for the
description and for what a viewer chose, float32 for poses and forces.
"""

from __future__ import annotations

import json
import struct
from dataclasses import asdict, dataclass
from typing import Any, BinaryIO, Self

import numpy as np
from numpy.typing import NDArray

from motionlab.scene3d.view_settings import ViewSettings

Values = NDArray[np.float32]

START, POSES, FORCES, CLEAR, VIEW = b"S", b"P", b"F", b"C", b"V"
"""Kinds: description of the scene; newer poses, shape (poses, width); forces of each phase at the
newest pose, which follows; reset of the trace; choices of a viewer."""

SHARED = ("position_reference", "load_force")
OWN = ("position", "thrust", "friction")
CURRENTS = ("current_a", "current_b", "current_c")
"""Channels of a pose; `column_names` has their order."""

RATE = 30.0
"""Poses per second."""

TRAIL_SECONDS = 4.0
"""Length of the trace, s of wall clock at full rate."""

_HEADER = struct.Struct("<cI")
_LONGEST = 4_000_000


@dataclass(frozen=True)
class DrawnAxis:
    """Drawn data of one axis.

    Attributes
    ----------
    stroke : float
        Largest distance from mid-stroke, m.
    pitch : float
        Pole pitch tau, m.
    offset : float
        Shift of the force map against the encoder, m.
    gap : float
        Air gap, m.
    """

    stroke: float
    pitch: float
    offset: float
    gap: float = 0.3e-3


@dataclass(frozen=True)
class SceneDescription:
    """Initial description of a scene.

    Attributes
    ----------
    origin : str
        The only Origin that the scene's server accepts.
    axes : tuple of DrawnAxis
        x and y.
    variants : dict of str to str
        Name of each stage and its label.
    path : list of pairs
        Commanded path, m.
    """

    origin: str
    axes: tuple[DrawnAxis, DrawnAxis]
    variants: dict[str, str]
    path: list[tuple[float, float]]

    def encode(self) -> bytes:
        """Return the message."""
        return message(START, json.dumps(asdict(self)).encode())

    @classmethod
    def decode(cls, payload: bytes) -> Self:
        """Decode a message's payload."""
        content: dict[str, Any] = json.loads(payload)
        x, y = (DrawnAxis(**axis) for axis in content.pop("axes"))
        return cls(axes=(x, y), **content)


def width(variants: int) -> int:
    """Return the count of numbers in a pose of so many variants."""
    return 2 * (len(SHARED) + variants * (len(OWN) + len(CURRENTS)))


def column_names(variants: list[str]) -> list[str]:
    """Return the names of a pose's numbers, in their order."""
    shared = [f"{axis}.{channel}" for channel in SHARED for axis in "xy"]
    forces = [f"{axis}.{channel}" for channel in OWN for axis in "xy"]
    currents = [f"{axis}.{channel}" for axis in "xy" for channel in CURRENTS]
    return shared + [f"{name}.{column}" for name in variants for column in forces + currents]


def positions_and_currents(pose: Values) -> tuple[Values, Values]:
    """Return positions and currents of a pose, from which the forces of phases follow.

    Parameters
    ----------
    pose : ndarray, shape (width,)
        One pose.

    Returns
    -------
    position : ndarray, shape (variants, 2)
        m.
    currents : ndarray, shape (variants, 2, 3)
        A.
    """
    own = pose[2 * len(SHARED) :].reshape(-1, 2 * (len(OWN) + len(CURRENTS)))
    return own[:, :2], own[:, 2 * len(OWN) :].reshape(-1, 2, 3)


def message(kind: bytes, payload: bytes = b"") -> bytes:
    """Return a message."""
    return _HEADER.pack(kind, len(payload)) + payload


def poses(values: Values) -> bytes:
    """Return the message of some poses, shape (poses, width), oldest first."""
    return message(POSES, np.ascontiguousarray(values, dtype="<f4").tobytes())


def forces(values: Values) -> bytes:
    """Return the message of each phase's forces, N.

    Parameters
    ----------
    values : ndarray, shape (variants, 2, 2, 3)
        Of each variant and axis, thrust and normal force of its three phases.
    """
    return message(FORCES, np.ascontiguousarray(values, dtype="<f4").tobytes())


def view(viewer: str, settings: ViewSettings) -> bytes:
    """Return the message of what a viewer chose."""
    return message(VIEW, viewer.encode() + b"\n" + settings.encode())


def decode_view(payload: bytes) -> tuple[str, ViewSettings]:
    """Return the viewer and what it chose."""
    viewer, _, content = payload.partition(b"\n")
    return viewer.decode(), ViewSettings.decode(json.loads(content))


def read(pipe: BinaryIO) -> tuple[bytes, bytes] | None:
    """Return kind and payload of the next message, or None where the pipe has ended.

    Raises
    ------
    ValueError
        If a message is longer than any can be.
    """
    header = pipe.read(_HEADER.size)
    if len(header) < _HEADER.size:
        return None
    kind, length = _HEADER.unpack(header)
    if length > _LONGEST:
        raise ValueError(f"a message of {length} bytes")
    payload = pipe.read(length)
    return (kind, payload) if len(payload) == length else None
