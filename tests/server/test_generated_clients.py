"""Clients that generators make from the OpenAPI document without a warning, and its examples."""

from __future__ import annotations

import compileall
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from jsonschema_rs import Draft202012Validator

from tests.paths import ROOT
from tests.server.openapi import body_examples

GENERATE = (sys.executable, "-m", "openapi_python_client", "generate", "--fail-on-warning")


def test_a_python_client_of_every_operation(tmp_path: Path, document: dict[str, Any]) -> None:
    path, config, client = (tmp_path / name for name in ("api.json", "config.json", "client"))
    path.write_text(json.dumps(document), encoding="utf-8")
    config.write_text(json.dumps({"post_hooks": []}), encoding="utf-8")  # which only format
    asked = ("--path", str(path), "--config", str(config), "--output-path", str(client))
    done = subprocess.run((*GENERATE, *asked), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stdout + done.stderr
    assert compileall.compile_dir(client, quiet=1)

    (package,) = client.glob("*/client.py")
    made = [m for m in (package.parent / "api").rglob("*.py") if m.name != "__init__.py"]
    operations = [o for methods in document["paths"].values() for o in methods.values()]
    assert len(made) == len(operations)
    for module in made:  # typed, and not merely called
        assert "sync_detailed(" in module.read_text(encoding="utf-8"), module


def test_every_accepted_job_is_of_one_kind(document: dict[str, Any]) -> None:
    kinds: dict[str, str] = {}
    for path, methods in document["paths"].items():
        for operation in methods.values():
            if "202" not in operation["responses"]:
                continue
            (content,) = operation["responses"]["202"]["content"].values()
            assert content["schema"].keys() == {"$ref"}, path
            report = document["components"]["schemas"][content["schema"]["$ref"].split("/")[-1]]
            kinds[path.removeprefix("/api/v1/")] = report["properties"]["kind"]["const"]
    assert kinds == {
        "simulate": "simulate",
        "sweep": "sweep",
        "loop/sweep": "frequency-sweep",
        "maps": "map",
        "friction-models": "friction-models",
        "safe-tune": "safe-tune",
        "identify": "identify",
        "learn": "learn",
        "minute": "minute",
        "montecarlo": "monte-carlo",
        "reproduce": "reproduce",
        "response": "response",
        "shape": "shape",
        "sensitivity": "sensitivity",
        "tune": "tune",
        "landscape": "landscape",
        "runs/{run_id}/replay": "replay",
        "runs/replay": "replays",
    }


SCRIPT = """\
import type { operations, paths } from '%s';

type Answer<P extends keyof paths, M extends keyof paths[P]> = paths[P][M] extends {
  responses: { 200: { content: { 'application/json': infer T } } };
}
  ? T
  : never;
type Problem<O extends keyof operations> = operations[O]['responses'] extends {
  422: { content: { 'application/problem+json': infer T } };
}
  ? T
  : never;
type Body = NonNullable<
  paths['/api/v1/simulate']['post']['requestBody']
>['content']['application/json'];

export const body: Body = {
  scenario: 'circle',
  set: { 'variants.B.controller.x.k_p': 4e5 },
  keep: false,
  name: '',
};
export const ratio = (found: Answer<'/api/v1/simulate', 'post'>): number | null =>
  found.comparison?.['x']?.max_abs_following_error_ratio ?? null;
export const health = (found: Answer<'/api/v1/health', 'get'>): 'ok' => found.status;
export function advice(problem: Problem<'simulate'>): string {
  if (problem.type === 'urn:motionlab:problem:infeasible-trajectory') return 'slow down';
  // @ts-expect-error a type that no problem has
  return problem.type === 'urn:motionlab:problem:no-such' ? '' : problem.errors[0]?.loc ?? '';
}
"""


def test_typescript_uses_every_operation_by_its_type(
    tmp_path: Path, document: dict[str, Any]
) -> None:
    """The types are those of the page, which test_generated.py holds against the document."""
    types = ROOT / "frontend" / "src" / "app" / "api" / "schema.d.ts"
    compiler = ROOT / "frontend" / "node_modules" / "typescript" / "bin" / "tsc"
    if not compiler.is_file():
        pytest.skip("no typescript: frontend/npm ci")
    script = tmp_path / "client.ts"
    each = "\n".join(
        f"export type Use{number} = operations['{operation['operationId']}']['responses'];"
        for number, operation in enumerate(
            operation for methods in document["paths"].values() for operation in methods.values()
        )
    )
    script.write_text(SCRIPT % types.with_suffix("").with_suffix("") + each, encoding="utf-8")
    options = ("--noEmit", "--strict", "--target", "es2022", "--moduleResolution", "bundler")
    node = (ROOT / "frontend" / "npm", "exec", "--", "node", compiler)
    done = subprocess.run(
        (*node, *options, "--module", "esnext", "--skipLibCheck", script),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_a_request_needs_has_an_example(document: dict[str, Any]) -> None:
    for path, methods in document["paths"].items():
        for operation in methods.values():
            name = operation["operationId"]
            if "requestBody" in operation:
                assert body_examples(document, name), f"{name}: the body"
            for parameter in operation.get("parameters", []):
                schema = parameter["schema"]
                told = "examples" in schema or "enum" in schema or "$ref" in schema
                assert told or not parameter.get("required"), f"{path}: {parameter['name']}"
                for example in schema.get("examples", []):
                    Draft202012Validator(schema).validate(example)
