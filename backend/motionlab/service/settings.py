"""Server settings, and limits on requests."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from motionlab.config.drive import DriveConfig

LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})


@dataclass(frozen=True)
class Settings:
    """Settings of one server.

    Attributes
    ----------
    token : str or None
        Token that clients must present; None, on loopback only: none is needed.
    hosts : frozenset of str
        Host names, without port, under which the server may be reached.
    body_max : int
        Largest request body, bytes.
    upload_max : int
        Largest file that is imported, bytes.
    direct_max : float
        Simulated time beyond which a simulation becomes a job, s.
    direct_work_max : float
        The same for simulated time summed over variants, s; bounds the memory of all that runs at
        once.
    work_max : float
        Largest simulated time summed over variants, s; bounds the time of a run.
    memory_max : int
        Memory for the recordings of all active runs, bytes; an hour of two variants takes
        3.8e9. `serve` lowers it to half of what the machine or container has.
    trials_max : float
        Largest simulated time of one search for gains, summed over trials and axes, s.
    answer_max : int
        Largest answer of curves, bytes.
    workers : int
        Calls that are computed at once, each by a process; the others wait.
    waiting_max : int
        Calls that may wait; one more is refused.
    jobs_at_once : int
        Jobs that run at once, each in a process; the others wait.
    jobs_max : int
        Jobs that may wait or run; one more is refused.
    jobs_kept : int
        Ended jobs that are kept in memory, of those that could not be recorded.
    map_vertices_max : int
        Nodes of the mesh of a force map; the reference preset of the paper's motor has 12161.
    sessions_max : int
        Live sessions.
    downloads_max : int
        Files of telemetry that are written or sent at once; others wait.
    downloads_waiting_max : int
        How many wait; one more is refused.
    connections_max : int
        Connections; a further one takes the place of the oldest that waits for its client.
    websockets_max : int
        Websockets among them; one more is refused.
    scenes_max : int
        Sessions that are shown in 3-D at once, each by a process.
    scheduler : str or None
        Where jobs are computed, docs/cluster.md; None for that of MOTIONLAB_SCHEDULER, or threads.
    drive : DriveConfig, optional
        The link to drives.
    """

    token: str | None = None
    hosts: frozenset[str] = field(default=LOOPBACK)
    body_max: int = 1_000_000
    upload_max: int = 200_000_000
    direct_max: float = 300.0
    direct_work_max: float = 600.0
    work_max: float = 7200.0
    memory_max: int = 4_000_000_000
    trials_max: float = 1e6
    answer_max: int = 64_000_000
    workers: int = 2
    waiting_max: int = 32
    jobs_at_once: int = 2
    jobs_max: int = 16
    jobs_kept: int = 64
    map_vertices_max: int = 60_000
    sessions_max: int = 32
    downloads_max: int = 8
    downloads_waiting_max: int = 64
    connections_max: int = 800
    websockets_max: int = 512
    scenes_max: int = 4
    scheduler: str | None = None
    drive: DriveConfig | None = None

    @property
    def bounds(self) -> Settings:
        """The same without token and drives, for processes that do not need them."""
        return replace(self, token=None, drive=None)
