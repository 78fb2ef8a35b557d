"""Settings of a server's application: its bounds, and who may reach it."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from motionlab.config.drive import DriveConfig
from motionlab.config.quantity import Config, quantity
from motionlab.declarations import OURS

LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})


def _bound(description: str, *, unit: str, default: float, ge: float = 1, le: float) -> Any:
    return quantity(description, unit=unit, source=OURS, default=default, ge=ge, le=le)


class Bounds(Config):
    """Bounds on requests, work and connections."""

    body_max: int = _bound("Body of a request", unit="bytes", default=1_000_000, le=1_000_000_000)
    upload_max: int = _bound("Imported file", unit="bytes", default=200_000_000, le=100_000_000_000)
    direct_max: float = _bound(
        "Time simulated by a direct answer; beyond, a job", unit="s", default=300.0, ge=0, le=1e6
    )
    direct_work_max: float = _bound(
        "The same, summed over variants; beyond, no what-if runs from the start",
        unit="s",
        default=600.0,
        ge=0,
        le=1e6,
    )
    work_max: float = _bound(
        "Time simulated by one request, summed over variants",
        unit="s",
        default=7200.0,
        ge=0,
        le=1e9,
    )
    memory_max: int = _bound(
        "Memory of all recordings and sessions; `serve` lowers it to half of the machine's",
        unit="bytes",
        default=4_000_000_000,
        le=1_000_000_000_000,
    )
    trials_max: float = _bound(
        "Time simulated by one gain search or cost map, over trials and axes",
        unit="s",
        default=1e6,
        ge=0,
        le=1e12,
    )
    answer_max: int = _bound(
        "Curves of one what-if", unit="bytes", default=64_000_000, le=1_000_000_000
    )
    workers: int = _bound(
        "Calls computed at once, and one more for short ones", unit="1", default=2, le=256
    )
    waiting_max: int = _bound(
        "Calls waiting for a worker, at most 30 s", unit="1", default=32, ge=0, le=10_000
    )
    jobs_at_once: int = _bound("Running jobs, one process each", unit="1", default=2, le=256)
    jobs_max: int = _bound("Jobs queued or running", unit="1", default=16, le=10_000)
    jobs_kept: int = _bound(
        "Ended jobs kept in memory if not recorded; 500 are recorded",
        unit="1",
        default=64,
        ge=0,
        le=10_000,
    )
    map_vertices_max: int = _bound(
        "Mesh nodes of a force map, preview or field; 12161 for the reference preset",
        unit="1",
        default=60_000,
        le=10_000_000,
    )
    sessions_max: int = _bound("Live sessions, 26 MB each", unit="1", default=32, ge=0, le=10_000)
    downloads_max: int = _bound(
        "Telemetry files written or sent at once", unit="1", default=8, le=1000
    )
    downloads_waiting_max: int = _bound(
        "Telemetry files waiting, at most 60 s", unit="1", default=64, ge=0, le=10_000
    )
    connections_max: int = _bound(
        "Connections; a new one replaces that which waits longest for its client",
        unit="1",
        default=800,
        le=100_000,
    )
    websockets_max: int = _bound("Websockets among them", unit="1", default=512, ge=0, le=100_000)
    scenes_max: int = _bound(
        "Sessions shown in 3-D, one process each", unit="1", default=4, ge=0, le=100
    )


class Settings(Bounds):
    """Settings of one application."""

    token: str | None = Field(
        default=None,
        description="What clients must present; None on loopback",
        repr=False,
    )
    hosts: frozenset[str] = Field(
        default=LOOPBACK, description="Host names, without port, under which it may be reached"
    )
    proxies: frozenset[str] = Field(
        default=frozenset(), description="Addresses and networks of proxies that are believed"
    )
    scheduler: str | None = Field(
        default=None,
        description="Where jobs are computed; None: as MOTIONLAB_SCHEDULER says",
    )
    drive: DriveConfig | None = Field(default=None, description="Link to drives")
    edit_laws: bool = Field(
        default=False, description="Whether files of laws of one's own may be changed"
    )

    @property
    def bounds(self) -> Settings:
        """The same without token and drives, for processes that do not need them."""
        return self.model_copy(update={"token": None, "drive": None})
