"""What the server is told when it starts, and the bounds on what a client may ask."""

from __future__ import annotations

from dataclasses import dataclass, field

LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})


@dataclass(frozen=True)
class Settings:
    """Settings of one server.

    Attributes
    ----------
    token : str or None
        What clients must present; None on loopback asks for none.
    hosts : frozenset of str
        Host names, without port, under which the server may be reached.
    body_max : int
        Largest request body, bytes.
    direct_max : float
        Simulated time beyond which a simulation becomes a job, s.
    work_max : float
        Largest simulated time summed over variants, s; bounds the memory of a run.
    running_max : int
        Simulations that run at once; one more is refused.
    jobs_max : int
        Jobs that may wait or run; one more is refused.
    jobs_kept : int
        Finished jobs whose results are kept.
    sessions_max : int
        Live sessions.
    """

    token: str | None = None
    hosts: frozenset[str] = field(default=LOOPBACK)
    body_max: int = 1_000_000
    direct_max: float = 300.0
    work_max: float = 7200.0
    running_max: int = 8
    jobs_max: int = 16
    jobs_kept: int = 64
    sessions_max: int = 16
