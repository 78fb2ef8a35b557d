"""The built page and documentation: where they are; compressed, and cached by browsers."""

from __future__ import annotations

import functools
import gzip
import os
from collections.abc import Iterator
from http import HTTPStatus
from mimetypes import guess_type
from pathlib import Path

from fastapi import FastAPI, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.staticfiles import StaticFiles
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, RedirectResponse, Response, StreamingResponse
from starlette.staticfiles import NotModifiedResponse
from starlette.types import Scope

from motionlab.files import page_root
from motionlab.server.http.compression import accepts

_HASHED = "assets"
"""Folder whose file names hold a hash of the content: such a file never changes."""

_CODINGS = {"br": ".br", "gzip": ".gz"}
"""Content codings, the smallest first, and how the files end that are packed so."""

_FOR_EVER = "public, max-age=31536000, immutable"
_PIECE = 64 * 1024  # bytes
_NOT_BUILT = "The page is not built: `make run` in a checkout builds and serves it."
_NO_HELP = (
    "The documentation is not built: `make docs` in a checkout builds it; docs/ has the text."
)
_TEXT = ("text/", "image/svg+xml", "application/json")
"""How media types begin that are worth compressing."""


def help_root() -> Path | None:
    """Return the folder of the built documentation, in the package or the checkout, if any."""
    package = Path(__file__).resolve().parents[2]
    for folder in (package / "help", package.parent.parent / "build" / "help"):
        if (folder / "index.html").is_file():
            return folder
    return None


class PageFiles(StaticFiles):
    """The files of the built page.

    FILE.br or else FILE.gz goes to clients that accept it; for others, FILE.gz is unpacked where
    there is no FILE. Hashed files are kept by browsers for good; the others are revalidated by
    their ETag.
    """

    def lookup_path(self, path: str) -> tuple[str, os.stat_result | None]:
        """Return where a file is, and its status: that of FILE.gz where there is no FILE."""
        file, status = super().lookup_path(path)
        if status is None:
            file, status = super().lookup_path(f"{path}.gz")
            file = file.removesuffix(".gz")
        return file, status

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        """Return the answer with a file, or that the client has it already."""
        path, request_headers = Path(full_path), Headers(scope=scope)
        hashed = path.parent.name == _HASHED
        headers = {"Cache-Control": _FOR_EVER if hashed else "no-cache"}
        sent = path
        for coding, ending in _CODINGS.items():
            packed = path.with_name(path.name + ending)
            if not packed.is_file():
                continue
            headers["Vary"] = "Accept-Encoding"
            if accepts(coding, request_headers):
                sent, stat_result = packed, packed.stat()
                headers["Content-Encoding"] = coding
                break
        media = guess_type(path.name)[0]
        if sent.is_file():
            response = FileResponse(
                sent, status_code, headers, media_type=media, stat_result=stat_result
            )
        else:
            headers["ETag"] = f'"{stat_result.st_mtime_ns:x}"'
            unpacked = _unpacked(path.with_name(f"{path.name}.gz"))
            response = StreamingResponse(unpacked, status_code, headers, media_type=media)
        if self.is_not_modified(response.headers, request_headers):
            return NotModifiedResponse(response.headers)
        return response


def _unpacked(path: Path) -> Iterator[bytes]:
    with gzip.open(path) as file:
        while piece := file.read(_PIECE):
            yield piece


class HelpFiles(PageFiles):
    """The files of the documentation; texts are compressed when they are first asked for."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Return the answer with a file."""
        response = await super().get_response(path, scope)
        text = (response.media_type or "").startswith(_TEXT)
        packed_before = "content-encoding" in response.headers
        if not text or packed_before or not isinstance(response, FileResponse):
            return response
        headers = response.headers
        headers["ETag"] = f"W/{headers['etag']}"  # plain or compressed
        headers["Vary"] = "Accept-Encoding"
        if not accepts("gzip", Headers(scope=scope)):
            return response
        body = await run_in_threadpool(_compressed, response.path, headers["etag"])
        packed = Response(body, response.status_code, media_type=response.media_type)
        kept = ("etag", "vary", "last-modified", "cache-control", "content-type")
        packed.headers.update({name: headers[name] for name in kept if name in headers})
        packed.headers["Content-Encoding"] = "gzip"
        return packed


@functools.lru_cache(maxsize=256)
def _compressed(path: str | os.PathLike[str], _version: str) -> bytes:
    return gzip.compress(Path(path).read_bytes())


def install(app: FastAPI) -> None:
    """Serve the page where it is built, with the API's own page at /docs, and the help at /help."""
    _install_help(app)
    root = page_root()
    files = None if root is None else PageFiles(directory=root, html=True)

    @app.get("/docs", include_in_schema=False)
    async def docs(request: Request) -> Response:
        if files is None:
            raise HTTPException(HTTPStatus.NOT_FOUND, _NOT_BUILT)
        return await files.get_response("docs.html", request.scope)

    if files is not None:
        app.mount("/", files)


def _install_help(app: FastAPI) -> None:
    root = help_root()
    app.state.documented = root is not None  # as mounted: it may be built while the server runs
    if root is not None:

        @app.get("/help", include_in_schema=False)
        def to_the_first_page() -> Response:
            return RedirectResponse("/help/")

        app.mount("/help", HelpFiles(directory=root, html=True))
        return

    @app.get("/help{page:path}", include_in_schema=False)
    def not_built(page: str) -> None:
        raise HTTPException(HTTPStatus.NOT_FOUND, _NO_HELP)
