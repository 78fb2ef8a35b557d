"""Generate from the program what a page has between `<!-- generated: NAME -->` and `<!-- end -->`.

On a forge a page shows what stands there: where to find it.
"""

import argparse
import base64
import json
import os
import re
from pathlib import Path

import motionlab
from motionlab.cli.main import _parser
from motionlab.config.fields import fields_of
from motionlab.config.scenario import Scenario
from motionlab.config.trajectory import EXAMPLES, KINDS
from motionlab.server.app import create_app
from motionlab.telemetry.channels import CHANNELS, REFERENCES

_MARK = re.compile(r"<!-- generated: ([a-z]+) -->.*?<!-- end -->", re.DOTALL)
_PAGE = re.compile(r"\bdocs/([\w-]+)\.md")
_README = Path(__file__).parent.parent / "README.md"


def generate(app, name, source):
    """Replace the marks of a page; pages beside docs/, such as the README, are linked as files."""
    if app.env.doc2path(name).suffix == ".ipynb":
        source[0] = _notebook(Path(app.outdir), name, json.loads(source[0]))
        return
    text = re.sub(r"\]\((\.\./\w+\.md)(#[^)]*)?\)", r"](path:\1)", source[0])
    source[0] = _MARK.sub(lambda found: _GENERATED[found[1]](), text)


def _notebook(site, name, notebook):
    """Return a notebook as Markdown: text, code, and what it printed and drew."""
    stem = name.rpartition("/")[2]
    (site / "_images").mkdir(parents=True, exist_ok=True)
    parts = []
    for number, cell in enumerate(notebook["cells"]):
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                file = f"{stem}-{number}.png"
                (site / "_images" / file).write_bytes(base64.b64decode(data["image/png"]))
                parts.append(f'<img src="../_images/{file}" alt="What the cell above draws">')
            else:
                printed = "".join(output.get("text") or data["text/plain"]).rstrip()
                parts.append(f"```text\n{printed}\n```")
    parts.append(f"To run it: {{download}}`{stem}.ipynb`.")
    return "\n\n".join(parts)


def link_pages(_app, _what, _name, _documented, _options, lines):
    """Make pages that a docstring names links."""
    lines[:] = [_PAGE.sub(r":doc:`\1`", line) for line in lines]


def contents():
    """Return the navigation: the groups and pages of README's table, in its order."""
    section = _README.read_text().partition("\n## Documentation\n")[2].partition("\n## ")[0]
    trees = []
    for title, table in re.findall(r"^\*\*(.+?)\*\*\n(.*?)(?=^\*\*|\Z)", section, re.M | re.S):
        pages = dict.fromkeys(re.findall(r"\]\(docs/([\w/-]+)\.(?:md|ipynb)\)", table))
        pages.pop("index", None)
        entries = "\n".join(pages)
        trees.append(f"```{{toctree}}\n:caption: {title}\n:hidden:\n:titlesonly:\n\n{entries}\n```")
    shown = re.sub(r"^.*CHANGELOG.*\n", "", section.replace("](docs/", "]("), flags=re.M)
    return "\n\n".join(trees) + "\n\n" + shown


def commands():
    """Return the help of every command of `motionlab`, each below a heading."""
    os.environ["COLUMNS"] = "100"  # which argparse takes for the width of the terminal
    return "\n".join(_helps(_parser(), "##"))


def _helps(parser, level):
    yield f"{level} `{parser.prog}`\n\n```text\n{parser.format_help().rstrip()}\n```\n"
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in dict.fromkeys(action.choices.values()):
                yield from _helps(command, level if level == "##" else level + "#")


def fields():
    """Return every field of a scenario, table by table; x and y in one row."""
    rows = {}
    for path, entry in fields_of(Scenario).items():
        if not path.startswith("trajectory.parts.*."):  # as those of `trajectory`
            of_both = re.sub(r"\.[xy](?=\.|$)", ".AXIS", path)
            rows.setdefault(of_both, []).append(entry)
    tables = {}
    for path, entries in rows.items():
        tables.setdefault(path.rpartition(".")[0], []).append(_field(path, entries))
    head = ("field", "unit", "range or choices", "default", "meaning")
    return "\n".join(
        f"## {f'`{table}`' if table else 'The scenario'}\n\n{_table(head, each)}"
        if table != "trajectory"
        else _kinds(head)
        for table, each in tables.items()
    )


def _kinds(head):
    """Return a table for each kind of trajectory, with an example."""
    parts = ["## `trajectory`\n\n`trajectory.kind` says which of these it is.\n"]
    for kind, model in KINDS.items():
        rows = {}
        for path, entry in fields_of(model).items():
            if "." not in re.sub(r"\.[xy]$", "", path):  # deeper tables follow
                rows.setdefault(re.sub(r"\.[xy]$", ".AXIS", path), []).append(entry)
        described = [_field(f"trajectory.{path}", entries) for path, entries in rows.items()]
        motion = f"trajectory = {{ kind = '{kind}', {EXAMPLES[kind]} }}"
        about = " ".join((model.__doc__ or "").split("\n\n")[0].split())
        parts.append(f"### {kind}\n\n{about}\n\n    {motion}\n\n{_table(head, described)}")
    return "\n".join(parts)


_SI = {
    "nm": "m",
    "µm": "m",
    "mm": "m",
    "µs": "s",
    "mm/s": "m/s",
    "°": "rad",
    "% of pitch": "1",
    "%": "1",
}
_SI |= {"N/mm": "N/m", "N s/mm": "N s/m"}


def _field(path, entries):
    first = entries[0]
    defaults = " (x), ".join(dict.fromkeys(_value(entry.default) for entry in entries))
    return (
        f"`{path}`",
        first.unit if first.factor == 1 else _SI[first.unit],
        _range(first),
        defaults + " (y)" * ("(x)" in defaults),
        first.description or first.label.removesuffix(" x"),
    )


def _range(entry):
    if entry.choices:
        return ", ".join(f"`{choice.value}`" for choice in entry.choices)
    words = {"minimum": "≥", "exclusive_minimum": ">", "maximum": "≤", "exclusive_maximum": "<"}
    return ", ".join(f"{words[name]} {value:g}" for name, value in (entry.bounds or {}).items())


def _value(value):
    return "" if value is None or isinstance(value, dict | list) else f"`{json.dumps(value)}`"


def channels():
    """Return the recorded channels of a lane, and those that all variants share."""

    def rows(prefix, table):
        return ((f"`{prefix}{each.name}`", each.unit, each.meaning, each.owner) for each in table)

    head = ("channel", "unit", "meaning", "of")
    return (
        f"## Of each axis\n\n{_table(head, rows('x.', REFERENCES))}\n"
        f"## Of each variant and axis\n\n{_table(head, rows('B.x.', CHANNELS))}"
    )


def operations():
    """Return a section for each operation of the OpenAPI document."""
    document = create_app().openapi()
    groups = {}
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            section = _operation(document, method, path, operation)
            groups.setdefault(operation["tags"][0], []).append(section)
    about = {tag["name"]: tag["description"] for tag in document["tags"]}
    return "\n".join(
        f"## {tag}\n\n{about[tag]}.\n\n" + "\n".join(each) for tag, each in groups.items()
    )


def _operation(document, method, path, operation):
    parts = [f"### {method.upper()} {path}\n", f"`{operation['operationId']}`. "]
    about = re.sub(r"``(.+?)``", r"`\1`", operation.get("description") or operation["summary"])
    parts[1] += _PAGE.sub(r"[\1](\1.md)", about)
    if parameters := operation.get("parameters"):
        head = ("parameter", "in", "type", "default", "meaning")
        rows = ((f"`{p['name']}`", p["in"], *_typed(document, p["schema"])) for p in parameters)
        parts.append("\n" + _table(head, rows))
    for media, content in operation.get("requestBody", {}).get("content", {}).items():
        parts.append(f"\nBody, `{media}`:\n\n{_body(document, content)}")
    answers = {code: _answer(each) for code, each in operation["responses"].items()}
    problems = [code for code, content in answers.items() if "problem+json" in content]
    rows = [
        (code, operation["responses"][code]["description"], content)
        for code, content in answers.items()
        if code not in problems
    ]
    rows += [(", ".join(sorted(problems)), "Refused or failed", "[Problem](rest.md#errors)")]
    parts.append("\n" + _table(("status", "meaning", "content"), rows))
    return "\n".join(parts)


def _body(document, content):
    schema = _resolved(document, content.get("schema", {}))
    rows = [
        (f"`{name}`", *_typed(document, each))
        for name, each in schema.get("properties", {}).items()
    ]
    text = _table(("field", "type", "default", "meaning"), rows) if rows else ""
    examples = [each["value"] for each in content.get("examples", {}).values()]
    examples += [content["example"]] if "example" in content else schema.get("examples", [])
    for example in examples[:1]:
        text += f"\n```json\n{json.dumps(example, indent=1, ensure_ascii=False)}\n```\n"
    return text


def _resolved(document, schema):
    name = schema.get("$ref", "").rpartition("/")[2]
    return document["components"]["schemas"][name] if name else schema


def _typed(document, schema):
    """Return type, default and meaning of a property or a parameter."""
    meaning = schema.get("description") or _resolved(document, schema).get("description", "")
    return _type(schema), _value(schema.get("default")), meaning.partition("\n\n")[0]


def _type(schema):
    if name := schema.get("$ref", "").rpartition("/")[2]:
        return name
    if several := schema.get("anyOf") or schema.get("oneOf"):
        return " or ".join(dict.fromkeys(map(_type, several)))
    if "enum" in schema or "const" in schema:
        return ", ".join(f"`{value}`" for value in schema.get("enum", [schema.get("const")]))
    if schema.get("type") == "array":
        return f"array of {_type(schema.get('items', {}))}"
    return schema.get("type", "any")


def _answer(response):
    contents = response.get("content", {})
    return ", ".join(
        f"{_type(each.get('schema', {}))} (`{media}`)" for media, each in contents.items()
    )


def python():
    """Return autodoc's directives: the public names of the package, then what they return."""
    found = []
    for name in motionlab.__all__:
        public = getattr(motionlab, name)
        kind = "class" if isinstance(public, type) else "function"
        kind = "exception" if kind == "class" and issubclass(public, Exception) else kind
        found.append(f"## {name}\n\n{_documented(kind, f'motionlab.{name}')}")
    for path in _RETURNED:
        name = path.rpartition(".")[2]
        found.append(f"## {name}\n\n{_documented('class', f'motionlab.scripting.{path}')}")
    return "\n".join(found)


_RETURNED = ("channels.Samples",)


def _documented(kind, path):
    members = "\n   :members:\n   :inherited-members: ndarray, Mapping" if kind == "class" else ""
    return f"```{{eval-rst}}\n.. auto{kind}:: {path}{members}\n```\n"


def _table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(map(_cell, line))} |\n" for line in lines)


def _cell(text):
    return " ".join(str(text).split()).replace("|", "\\|").replace("<", "&lt;")


_GENERATED = {
    "contents": contents,
    "commands": commands,
    "fields": fields,
    "channels": channels,
    "operations": operations,
    "python": python,
}
