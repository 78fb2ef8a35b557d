"""What the README shows of the REST interface is what happens."""

from __future__ import annotations

import os
import re
import subprocess
import sys

from tests.paths import ROOT
from tests.project.printed_output import same_text
from tests.server.servers import Server

EXAMPLE = ROOT / "examples" / "ab.py"


def test_the_readme_prints_the_example_and_what_it_answers(server: Server) -> None:
    readme = (ROOT / "README.md").read_text()
    block = r"```python\n((?:(?!```).)*)```\n\nprints\n\n((?:    [^\n]*\n)+)"
    shown = re.search(block, readme, re.DOTALL)
    assert shown is not None
    assert shown[1] == EXAMPLE.read_text()
    answer = subprocess.run(
        [sys.executable, EXAMPLE],
        env=os.environ | {"LAB": server.url},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert same_text(re.sub("^    ", "", shown[2], flags=re.MULTILINE), answer), answer


def test_the_example_is_short() -> None:
    assert len(EXAMPLE.read_text().splitlines()) < 20
