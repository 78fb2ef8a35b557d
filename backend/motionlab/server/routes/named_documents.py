"""Routes of a store of named documents: list, get, put, delete."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from fastapi import APIRouter, Request, Response
from starlette.concurrency import run_in_threadpool

from motionlab.library.named_documents import NamedDocuments
from motionlab.server.http.problems import responses
from motionlab.server.worker_answers import ComputedResponse, called, json_of
from motionlab.server.workers.worker import Call


@dataclass(frozen=True)
class DocumentRoutes:
    """Adds routes of a store to a router, each when its method is called."""

    router: APIRouter
    store: Callable[[], NamedDocuments[Any, Any]]  # workers import it by its name
    nouns: tuple[str, str]  # words of operation ids, such as GainSet and GainSets
    name: Any  # annotated type of the names
    path: str = "/{name}"
    in_worker: bool = False  # workers use the index, threads the files of what may ship

    def list(self, entry: type, description: str) -> None:
        """Add the list of entries."""

        async def endpoint(request: Request) -> Any:
            return await self._answer(request, _result, self.store, "all")

        self._add("list", endpoint, description, response_model=list[entry])

    def get(self, document: type, description: str) -> None:
        """Add the reading of a document."""

        async def endpoint(request: Request, name: str) -> Any:
            return await self._answer(request, _result, self.store, "get", name)

        self._add("get", endpoint, description, 404, response_model=document)

    def put(
        self,
        body: Any,
        document: type,
        description: str,
        *,
        save: Callable[[str, Any], Any] | None = None,
        light: bool = True,
    ) -> None:
        """Add the saving of a document, by the store or by a function of name and body."""
        saving = (_result, self.store, "put") if save is None else (save,)

        async def endpoint(request: Request, name: str, body: Any) -> Any:
            return await self._answer(request, *saving, name, body, light=light)

        endpoint.__annotations__["body"] = body
        self._add("put", endpoint, description, 400, 413, 415, 507, response_model=document)

    def delete(self, description: str) -> None:
        """Add the deletion of a document."""

        async def endpoint(request: Request, name: str) -> Response:
            call = (_result, self.store, "delete", name)
            if self.in_worker:
                (await called(request, _json, *call, light=True)).close()
            else:
                await run_in_threadpool(*call)
            return Response(status_code=204)

        self._add("delete", endpoint, description, 404, status_code=204)

    async def _answer(self, request: Request, *call: Any, light: bool = True) -> Any:
        if self.in_worker:
            return ComputedResponse(await called(request, _json, *call, light=light))
        return await run_in_threadpool(*call)

    def _add(
        self,
        verb: Literal["list", "get", "put", "delete"],
        endpoint: Callable[..., Any],
        description: str,
        *statuses: int,
        **options: Any,
    ) -> None:
        operation = verb + self.nouns[verb == "list"]
        if verb != "list":
            endpoint.__annotations__["name"] = self.name
        if self.in_worker:
            statuses += (429, 503)
        elif verb in {"put", "delete"}:
            statuses += (409, 503)
        self.router.add_api_route(
            "" if verb == "list" else self.path,
            endpoint,
            methods=["GET" if verb == "list" else verb.upper()],
            operation_id=operation,
            summary=re.sub("(?=[A-Z])", " ", operation).title(),
            description=description,
            responses=responses(*sorted(statuses)),
            **options,
        )


def _json(call: Call, function: Callable[..., Any], *arguments: Any) -> bytes:
    return json_of(call, function, arguments)


def _result(store: Callable[[], Any], method: str, *arguments: Any) -> Any:
    return getattr(store(), method)(*arguments)
