"""Every file of docs/extending.md is written, and its command prints the page's numbers."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.paths import ROOT
from tests.project.printed_output import same_text
from tests.project.test_documented_commands import bash, outdent

PAGE = ROOT / "docs" / "extending.md"
EXAMPLE = re.compile(
    r"^## (.+)\n(?:(?!## ).*\n)*?`([\w/]+\.py)`:\n\n```python\n((?:.*\n)*?)```\n\n"
    r"((?:    .*\n)+)\nprints\n\n((?:    .*\n)+)",
    re.MULTILINE,
)


class Example(NamedTuple):
    """A section of the page: its file, its commands, and what the last one prints."""

    title: str
    file: str
    text: str
    commands: str
    printed: str


EXAMPLES = [Example(*found) for found in EXAMPLE.findall(PAGE.read_text())]


def test_every_section_has_an_example() -> None:
    sections = re.findall(r"^## (.+)$", PAGE.read_text(), re.MULTILINE)
    assert [each.title for each in EXAMPLES] == [each for each in sections if "Own" in each]
    assert len(EXAMPLES) == len("law friction effect trajectory study view".split())


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda each: each.title)
def test_an_example_prints_what_the_page_says(example: Example, tmp_path: Path) -> None:
    file = tmp_path / example.file
    file.parent.mkdir(exist_ok=True)
    file.write_text(example.text)
    # Not by forks, which have all laws already.
    done = bash(outdent(example.commands), tmp_path, Path(sys.prefix))
    assert done.returncode == 0, done.stderr + done.stdout
    assert same_text(outdent(example.printed).rstrip(), done.stdout), done.stdout


@pytest.mark.parametrize(
    "word", ["own law", "Own study", "plugin", "ILC", "cogging", "friction model"]
)
def test_the_page_has_the_words_that_it_is_looked_for_by(word: str) -> None:
    assert word in PAGE.read_text()
