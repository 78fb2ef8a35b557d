"""``motionlab challenge`` with the file of a law of one's own, and its table on the page."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from motionlab.cli import main
from motionlab.own_laws.template import template
from motionlab.studies.challenge.documents import ChallengeDocument
from tests.paths import DOCS
from tests.studies.challenge.test_definition import DIGESTS

MINE = template("mine")
DOCS_PAGE = (DOCS / "challenge.md").read_text()
EXAMPLE = (DOCS / "own-law.md").read_text().partition("```python\n")[2].partition("```")[0]


def command(*words: str | Path, **variables: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "motionlab", "challenge", *map(str, words)]
    environment = os.environ | variables
    return subprocess.run(line, env=environment, capture_output=True, text=True, check=False)


def test_laws_of_ones_own_are_ranked_and_have_a_page(tmp_path: Path) -> None:
    """Whole, as a stranger enters; a file wins over one of the same name elsewhere."""
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "super_twisting.py").write_text(EXAMPLE)
    other = tmp_path / "other.py"
    other.write_text(MINE.replace("F_c with the sign", "Something else with the sign"))
    page = tmp_path / "mine.html"
    files = [tmp_path / name for name in ("mine.py", "super_twisting.py")]
    words = (*files, "--set", "mine_share=0.5", "-o", page, "--json")
    done = command(*words, MOTIONLAB_LAWS=str(other))
    assert done.returncode == 0, done.stderr
    document = ChallengeDocument.model_validate(json.loads(done.stdout))
    assert document.digest == DIGESTS[document.challenge]
    assert len(document.titles) == 10
    example, mine = (law for law in document.laws if law.entered)
    assert mine.label == "mine mine_share=0.5"
    assert mine.description == "F_c with the sign of the reference's velocity"
    assert mine.verdict == "holds"
    assert mine.score is not None
    assert 0.9 < mine.score < 1.0, "half of F_c, where F_s is much more"
    assert mine.source is not None
    assert mine.source in page.read_text()
    shown = re.search(r"comes first with (\S+), with", DOCS_PAGE)
    assert shown is not None
    assert (example.law, example.rank, example.verdict) == ("super-twisting", 1, "holds")
    assert example.score == pytest.approx(float(shown[1]), rel=0.01)
    assert command(*words).returncode == 2, "the page is there already"


def test_files_that_cannot_be_taken_are_named_with_their_lines(tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text(MINE.replace("Estimate(", "Estimate(("))
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "same.py").write_text(MINE)
    files = [tmp_path / name for name in ("bad.py", "mine.py", "same.py", "none.py")]
    done = command(*files)
    assert done.returncode == 2
    said = done.stderr.splitlines()
    assert said[0].startswith(f"motionlab: {files[0]}:13: bad: SyntaxError")
    assert f"{files[2]}: mine.name: has the name of the law of {files[1]}" in said[1]
    assert f"LAW: is no file; got '{files[3]}'" in said[2]
    assert len(said) == 3
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["no-law"], "LAW: no such law"),
        (["canudas-de-wit", "--set", "gain=nan"], "--set gain: must be a finite number; got nan"),
        (["off", "--set", "gain=1"], "--set gain: no law that is named has this parameter"),
        (["--seed=-1"], "--seed: is negative"),
        (["--out", "page.txt"], ".html"),
    ],
)
def test_other_words_are_refused(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["challenge", *words]) == 2
    assert complaint in capsys.readouterr().err


def test_a_law_of_a_folder_is_entered_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(MINE)
    done = command("mine", "--laws", tmp_path, "--set", "mine_share=9")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == (
        "motionlab: --set mine_share: is out of range; got 9; allowed >= 0 and <= 2"
    )
