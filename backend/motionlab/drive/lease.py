"""The lease: who may move the drives. One holder at a time, kept by a heartbeat."""

from __future__ import annotations

import hmac
import secrets
import time
from dataclasses import dataclass

from motionlab.errors import MotionLabError

SECONDS = 2.0
"""Time without a heartbeat after which a lease ends, s."""

ASKED = 60.0
"""Time for which the holder sees who asks for control, s."""


class NotHeld(MotionLabError):
    """A command that needs the lease, from someone who does not hold it."""

    kind = "lease-not-held"


@dataclass
class Lease:
    """Command authority over the drives."""

    holder: str = ""
    since: float = 0.0  # wall clock, s
    _token: str = ""
    _until: float = 0.0
    _asking: tuple[str, float] = ("", 0.0)

    @property
    def expired(self) -> bool:
        """Whether the holder's heartbeat has stopped."""
        return bool(self._token) and time.monotonic() >= self._until

    @property
    def asking(self) -> str:
        """Who asked the holder for control lately; empty for no one."""
        name, until = self._asking
        return name if self._token and time.monotonic() < until else ""

    def ask(self, name: str) -> None:
        """Let the holder know who would like control.

        Raises
        ------
        NotHeld
            If no one has it: there is no holder to ask.
        """
        if not self._token:
            raise NotHeld("no one controls the drives: take control")
        self._asking = name, time.monotonic() + ASKED

    def take(self, holder: str) -> str:
        """Return the token of a new lease.

        Raises
        ------
        NotHeld
            If somebody else holds it.
        """
        if self._token:  # also while what an expired one was moving comes to rest
            raise NotHeld(f"{self.holder!r} controls the drives")
        self.holder, self.since = holder, time.time()
        self._token = secrets.token_urlsafe(16)
        self._asking = ("", 0.0)
        self._until = time.monotonic() + SECONDS
        return self._token

    def renew(self, token: str) -> None:
        """Keep the lease for another while."""
        self.check(token)
        self._until = time.monotonic() + SECONDS

    def end(self) -> None:
        """Let it expire at once; it is free as soon as nothing moves."""
        self._until = 0.0

    def free(self) -> None:
        """Let somebody else take it."""
        self.holder, self._token, self._until = "", "", 0.0

    def check(self, token: str) -> None:
        """Refuse who does not hold it.

        Raises
        ------
        NotHeld
            Saying who does.
        """
        own = self._token and hmac.compare_digest(token.encode(), self._token.encode())
        if own and not self.expired:
            return
        if own:
            raise NotHeld(f"the lease has ended: no heartbeat for {SECONDS:g} s")
        who = f"{self.holder!r} controls" if self._token else "no one controls"
        raise NotHeld(f"{who} the drives: take control first")
