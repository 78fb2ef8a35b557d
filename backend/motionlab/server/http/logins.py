"""Log-ins of browsers: signed cookies that expire, and a bound on attempts."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import secrets
from collections import deque
from time import monotonic
from typing import NamedTuple

LIFETIME = 12 * 3600
"""Seconds after which an unused log-in expires."""

ATTEMPTS_MAX = 10
"""Log-ins with a wrong token of one client address within `ATTEMPTS_SECONDS`."""

ATTEMPTS_MAX_IN_ALL = 60
"""Log-ins with a wrong token of all clients within `ATTEMPTS_SECONDS`."""

ATTEMPTS_SECONDS = 60.0
_LOOK = 60.0  # s between two looks at a log-in that may have been renewed


class Login(NamedTuple):
    """Contents of a valid cookie."""

    id: str
    expires: float

    @property
    def is_ageing(self) -> bool:
        """Whether half of its life is over: time for a fresh cookie."""
        return self.expires - monotonic() < LIFETIME / 2


class Attempts:
    """The wrong tokens of the last minute."""

    def __init__(self) -> None:
        self._latest: deque[tuple[float, str]] = deque()

    def take(self, address: str) -> float:
        """Count an attempt of a client; return 0, or the seconds to wait where it is refused."""
        now = monotonic()
        while self._latest and self._latest[0][0] <= now - ATTEMPTS_SECONDS:
            self._latest.popleft()
        own = [at for at, who in self._latest if who == address]
        oldest = None
        if len(self._latest) >= ATTEMPTS_MAX_IN_ALL:
            oldest = self._latest[0][0]
        elif len(own) >= ATTEMPTS_MAX:
            oldest = own[0]
        if oldest is not None:
            return oldest + ATTEMPTS_SECONDS - now
        self._latest.append((now, address))
        return 0.0


class Logins:
    """Cookies in place of the token: ``id.expiry.signature``, signed by HMAC-SHA256.

    The key comes from the token and a secret of this process: another token, another server and a
    restart end every log-in. Expiries count on the monotonic clock.

    Attributes
    ----------
    attempts : Attempts
        The latest log-ins with a wrong token.
    wrong_tokens : Attempts
        The latest requests with a wrong bearer token: each is refused, and so many are logged.
    """

    def __init__(self, token: str | None) -> None:
        self._key = hmac.digest(secrets.token_bytes(32), (token or "").encode(), "sha256")
        self._ended: dict[str, float] = {}
        self._expiries: dict[str, float] = {}
        self._ends: dict[str, asyncio.Event] = {}
        self.attempts = Attempts()
        self.wrong_tokens = Attempts()

    def issue(self, login: Login | None = None) -> str:
        """Return the value of a cookie for a new log-in, or a fresh one for a log-in."""
        name = secrets.token_urlsafe(16) if login is None else login.id
        now = monotonic()
        self._expiries = {each: until for each, until in self._expiries.items() if until > now}
        self._ends = {each: end for each, end in self._ends.items() if each in self._expiries}
        expires = int(now) + LIFETIME
        self._expiries[name] = float(expires)
        return self._signed(f"{name}.{expires}")

    def verify(self, value: str) -> Login | None:
        """Return the login of a cookie, None if invalid or expired."""
        content = value.rpartition(".")[0]
        if not hmac.compare_digest(value.encode(), self._signed(content).encode()):
            return None
        name, _, expires = content.partition(".")
        login = Login(name, float(expires))
        valid = name not in self._ended and login.expires > monotonic()
        return login if valid else None

    def end(self, login: Login) -> None:
        """Refuse every cookie of a log-in from now on."""
        now = monotonic()
        self._ended = {name: until for name, until in self._ended.items() if until > now}
        self._ended[login.id] = now + LIFETIME
        if (event := self._ends.pop(login.id, None)) is not None:
            event.set()

    async def over(self, login: Login) -> None:
        """Wait for the end of a log-in: its log-out, or the expiry of its last cookie."""
        event = self._ends.setdefault(login.id, asyncio.Event())
        while (left := self._expiries.get(login.id, login.expires) - monotonic()) > 0:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(min(left, _LOOK)):
                    await event.wait()
            if event.is_set():
                return

    def _signed(self, content: str) -> str:
        return f"{content}.{hmac.digest(self._key, content.encode(), 'sha256').hex()}"


def cookie_name(host: str) -> str:
    """Return the cookie's name for a Host header; a browser sends cookies to every port."""
    port = host.rpartition(":")[2]
    return f"motionlab_{port}" if port.isdigit() else "motionlab"


def set_cookie(name: str, value: str, *, secure: bool) -> str:
    """Return the Set-Cookie header of a log-in; without a value, of a log-out."""
    age = LIFETIME if value else 0
    header = f"{name}={value}; HttpOnly; Max-Age={age}; Path=/; SameSite=Strict"
    return f"{header}; Secure" if secure else header
