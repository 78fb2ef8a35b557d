"""What a Dockerfile and its .dockerignore say, as far as this project's do."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from tests.paths import ROOT


@dataclass(frozen=True)
class Stage:
    """One stage.

    Attributes
    ----------
    base : str
        Image that it begins from.
    name : str
        What follows AS; empty for the last.
    steps : list of (str, str)
        Instructions and their arguments, in order.
    """

    base: str
    name: str
    steps: list[tuple[str, str]] = field(default_factory=list)

    def last(self, instruction: str) -> str:
        """Return the arguments of the last of an instruction, the one that counts."""
        return [argument for found, argument in self.steps if found == instruction][-1]

    def environment(self) -> dict[str, str]:
        """Return what ENV sets, references to variables as they stand."""
        words = [argument for found, argument in self.steps if found == "ENV"]
        return dict(word.split("=", 1) for text in words for word in shlex.split(text))


def stages(path: Path = ROOT / "backend" / "Dockerfile") -> list[Stage]:
    """Return the stages of a Dockerfile."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    found: list[Stage] = []
    for line in re.sub(r"\\\n\s*", "", "\n".join(lines)).splitlines():
        instruction, _, argument = line.strip().partition(" ")
        if instruction == "FROM":
            base, _, name = argument.partition(" AS ")
            found.append(Stage(base, name))
        elif instruction:
            found[-1].steps.append((instruction, argument.strip()))
    return found


def copied(argument: str) -> tuple[str, list[str], str]:
    """Return stage (empty for the checkout), sources and target of a COPY."""
    words = shlex.split(argument)
    stage = words.pop(0).removeprefix("--from=") if words[0].startswith("--from=") else ""
    return stage, words[:-1], words[-1]


def copy(argument: str, root: Path, here: str, others: dict[str, Path]) -> None:
    """Carry out a COPY, without what .dockerignore keeps out.

    Parameters
    ----------
    argument : str
        What follows COPY.
    root : Path
        Root folder of the stage.
    here : str
        WORKDIR.
    others : dict of str to Path
        Root folders of earlier stages, by name.
    """
    stage, sources, target = copied(argument)
    into = root / os.path.join(here, target).lstrip("/")

    def kept_out(folder: str, names: list[str]) -> set[str]:
        inside = Path(folder)
        return {n for n in names if is_ignored(str((inside / n).relative_to(ROOT)))}

    for source in sources:
        origin = others[stage] / source.lstrip("/") if stage else ROOT / source
        if origin.is_dir():
            ignore = None if stage else kept_out
            shutil.copytree(origin, into, symlinks=True, ignore=ignore, dirs_exist_ok=True)
        else:
            name = origin.name if target.endswith("/") else ""
            (into / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(origin, into / name)


def command(argument: str) -> list[str]:
    """Return the words of a CMD or HEALTHCHECK in its exec form."""
    return json.loads(argument[argument.index("[") :])


def is_ignored(path: str, ignore: Path = ROOT / ".dockerignore") -> bool:
    """Return whether a path is kept out of the build; the last rule that fits decides."""
    lines = [line.strip() for line in ignore.read_text().splitlines()]
    whole = PurePosixPath(path)
    candidates = [str(part) for part in (whole, *whole.parents) if str(part) != "."]
    ignored = False
    for line in lines:
        if line and not line.startswith("#"):
            rule = re.compile(_pattern(line.removeprefix("!")))
            if any(rule.fullmatch(candidate) for candidate in candidates):
                ignored = not line.startswith("!")
    return ignored


def _pattern(rule: str) -> str:
    text = re.escape(rule.strip("/")).replace(r"\[", "[").replace(r"\]", "]")
    return text.replace(r"\*\*/", "(?:.*/)?").replace(r"\*", "[^/]*")
