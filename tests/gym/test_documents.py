"""The page and the example do what they say."""

import re

from tests.paths import ROOT


def test_the_page_runs():
    page = (ROOT / "docs" / "gymnasium.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert len(blocks) == 2
    names = {}
    for block in blocks:
        exec(block, names)
    observation, info = names["envs"].reset(seed=1)
    assert observation.shape == (64, 16)
    assert len(set(info["case"].tolist())) > 10


def test_the_example_learns(capsys):
    source = (ROOT / "examples" / "learn_residual.py").read_text()
    for full, smaller in (("64, 8, 25", "32, 6, 7"), ("3.0  # s", "0.2")):
        assert full in source
        source = source.replace(full, smaller)
    # a fifth of a second does not teach a whole circle: there, only the scores count
    exec(source[: source.index("for name, weights in")], {"__name__": "example"})
    scores = re.findall(r"mean policy (\S+), best", capsys.readouterr().out)
    assert float(scores[-1]) > float(scores[0])
