"""Checks of every request before the application: host, origin, token, size."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import logging
from http import HTTPStatus
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import cookie_parser
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from motionlab.reports.problems import Kind
from motionlab.server.http.access_log import KNOWN
from motionlab.server.http.logins import Login, Logins, cookie_name, set_cookie
from motionlab.server.http.problems import problem
from motionlab.server.settings import Settings

OPEN_PATHS = frozenset({"/api/v1/health", "/api/v1/login"})
"""Paths of the API without a token; the page, which asks for it, needs none either."""

_NEEDS_TOKEN = ("/api/", "/docs", "/openapi.json", "/asyncapi.json", "/metrics", "/scene")

_WORKS = ("/api/", "/scene")
"""Paths closed even to reads from pages of other sites: some of them start work."""

UPLOAD_PATH = "/api/v1/runs/import"
"""Where a body is a file, with a bound of its own."""

_LOG = logging.getLogger(__name__)
_SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
_OWN_SITES = {"same-origin", "none"}  # of Sec-Fetch-Site; none: the address was typed
_POLICY_VIOLATION = 1008
_FAREWELL = 1.0  # s for a client to take the reason
CONTENT_POLICY = (
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; object-src 'none'; base-uri 'none'; form-action 'self'; "
    "frame-ancestors 'self'"
)
_HEADERS = {
    "Content-Security-Policy": CONTENT_POLICY,
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "SAMEORIGIN",
}


class Guard:
    """ASGI middleware that refuses requests outside the settings.

    A page of another site can make a browser send requests here. Checking Host defeats DNS
    rebinding, where Origin and Host agree on a foreign name; checking Origin on writes and on
    websockets defeats the rest. Scripts send no Origin and are not hindered.
    """

    def __init__(self, app: ASGIApp, settings: Settings, logins: Logins) -> None:
        self.app = app
        self.settings = settings
        self.logins = logins

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope["type"] not in {"http", "websocket"}:
            await self.app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is None and scope["type"] == "websocket":
            await self._stream(scope, receive, send)  # no body to bound, no headers to add
        elif refusal is None:
            await self._serve(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": refusal[1]})
        else:
            kind, detail = refusal
            headers = {"WWW-Authenticate": "Bearer"} if kind == "token-needed" else None
            await problem(kind, detail, headers=headers)(scope, receive, _protected(send))

    async def _stream(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a websocket, which ends with the log-in that it came by."""
        headers = Headers(scope=scope)
        login = None if "authorization" in headers else find_login(headers, self.logins)
        if self.settings.token is None or login is None:
            await self.app(scope, receive, send)
            return
        serving = asyncio.create_task(self._run(scope, receive, send))
        over = asyncio.create_task(self.logins.over(login))
        try:
            await asyncio.wait({serving, over}, return_when=asyncio.FIRST_COMPLETED)
            if not serving.done():
                serving.cancel()
                closing = {"type": "websocket.close", "code": _POLICY_VIOLATION}
                with contextlib.suppress(RuntimeError, OSError, TimeoutError):  # it has left
                    async with asyncio.timeout(_FAREWELL):
                        await send({**closing, "reason": "the log-in has ended"})
                with contextlib.suppress(asyncio.CancelledError):
                    await serving
                return
            await serving
        finally:
            over.cancel()
            serving.cancel()

    async def _run(self, scope: Scope, receive: Receive, send: Send) -> None:
        await self.app(scope, receive, send)

    def _refusal(self, scope: Scope) -> tuple[Kind, str] | None:
        """Return type and reason for turning a request away, or None."""
        headers = Headers(scope=scope)
        hosts = headers.getlist("host")
        if len(hosts) != 1:  # which of several is meant is a guess, on which proxies differ
            return "invalid-host", f"{len(hosts)} Host headers; there has to be one"
        host = hosts[0].lower()
        if _name(host) not in self.settings.hosts:
            return "foreign-request", f"host {host!r} is not one of this server's names"
        foreign = _foreign(scope, headers, host)
        if foreign is not None:
            return "foreign-request", foreign
        known = self._knows_token(headers)
        scope.setdefault("extensions", {})[KNOWN] = known
        closed = scope["path"].startswith(_NEEDS_TOKEN) and scope["path"] not in OPEN_PATHS
        if closed and not known:
            self._note_wrong_token(headers, (scope.get("client") or ("",))[0])
            return "token-needed", "a token is needed: Authorization: Bearer <token>"
        length = headers.get("content-length", "0")
        most = self._body_max(scope)
        if not length.isdecimal() or int(length) > most:
            detail = f"body of {length} bytes; at most {most}"
            return "body-too-large", detail
        return None

    def _body_max(self, scope: Scope) -> int:
        upload = scope["path"] == UPLOAD_PATH
        return self.settings.upload_max if upload else self.settings.body_max

    def _knows_token(self, headers: Headers) -> bool:
        token = self.settings.token
        if token is None:
            return True
        presented = _bearer(headers)
        if presented is not None:
            return hmac.compare_digest(presented.encode(), token.encode())
        return find_login(headers, self.logins) is not None

    def _note_wrong_token(self, headers: Headers, address: str) -> None:
        if _bearer(headers) is not None and self.logins.wrong_tokens.take(address) == 0.0:
            _LOG.warning("request of %.60r refused: wrong token", address)

    def _renewed(self, scope: Scope) -> str | None:
        """Return the fresh cookie for a browser whose log-in is in use and ageing."""
        headers = Headers(scope=scope)
        login = find_login(headers, self.logins)
        if login is None or not login.is_ageing:
            return None
        name = cookie_name(headers.get("host", ""))
        return set_cookie(name, self.logins.issue(login), secure=scope["scheme"] == "https")

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        received = 0
        most = self._body_max(scope)

        async def bounded() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > most:
                raise HTTPException(
                    HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"body of more than {most} bytes"
                )
            return message

        answered = False
        fresh = self._renewed(scope)

        async def sent(message: Message) -> None:
            nonlocal answered
            answered = True
            if fresh is not None and message["type"] == "http.response.start":
                MutableHeaders(scope=message).setdefault("set-cookie", fresh)
            await send(message)

        try:
            await self.app(scope, bounded, _protected(sent))
        except Exception:
            if answered:
                raise
            _LOG.exception("%s %s failed", scope["method"], scope["path"])
            failed = problem("internal-error", "unexpected; the server's log tells")
            await failed(scope, receive, _protected(send))


def _bearer(headers: Headers) -> str | None:
    """Return the token that a request presents, None without one."""
    scheme, _, token = headers.get("authorization", "").partition(" ")
    return token.strip() if scheme.lower() == "bearer" else None


def find_login(headers: Headers, logins: Logins) -> Login | None:
    """Return the log-in of a request's cookie, None where it has no valid one."""
    # Lenient: what other servers of this host have set may be no valid cookie.
    cookies = cookie_parser(headers.get("cookie", ""))
    return logins.verify(cookies.get(cookie_name(headers.get("host", "")), ""))


def _protected(send: Send) -> Send:
    """Return `send` with the headers that every answer carries."""

    async def protected(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return protected


def _foreign(scope: Scope, headers: Headers, host: str) -> str | None:
    """Return why a request of a foreign page is refused, or None."""
    origin, site = headers.get("origin"), headers.get("sec-fetch-site", "none")
    works = scope["path"].startswith(_WORKS)
    writes = scope["type"] == "websocket" or scope["method"] not in _SAFE
    if (writes or works) and origin is not None and _origin_host(origin) != host:
        return f"origin {origin!r} is not this server"
    if works and site not in _OWN_SITES:
        return f"a {site} request: open the lab's own page first"
    return None


def _origin_host(origin: str) -> str:
    """Return host and port of an Origin header; nothing where it is not one."""
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return ""


def _name(host: str) -> str:
    """Return a Host header without its port."""
    name, separator, port = host.rpartition(":")
    return name if separator and port.isdigit() else host
