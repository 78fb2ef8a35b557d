"""Bounds on texts, tables, paths and complaints: what is too much is refused before it costs."""

from __future__ import annotations

import tomllib

import pytest

from motionlab.config import changes, named_configs, validation_errors
from motionlab.config.bounds import DEPTH_MAX, KEYS_MAX, check_depth
from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import config_root, parse, parse_text
from motionlab.errors import SHOWN_MAX, ConfigError, FieldError, shown

LONG = "b." * 1000 + "c"


def parsed(text: str, size_max: int = 1_000_000) -> dict[str, object]:
    return parse_text(text.encode(), loc="body", size_max=size_max)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("a." * 100_000 + "a=1", "nested too deeply"),
        ("[" + "a." * 100_000 + "a]", "nested too deeply"),
        ("a . " * 50_000 + "a=1", "nested too deeply"),
        ('"a".' * 50_000 + "a=1", "nested too deeply"),
        ("'a'." * 50_000 + "a=1", "nested too deeply"),
        ("a=" + "[" * 5000 + "]" * 5000, "nested too deeply"),
        ("a=" + "{a=" * 50 + "1" + "}" * 50, "nested too deeply"),
        ("".join(f"[a{n}]\n" for n in range(50_000)), "too many keys"),
        ("".join(f"a{n}=1\n" for n in range(50_000)), "too many keys"),
        ("a={" + ",".join(f"a{n}=1" for n in range(50_000)) + "}", "too many keys"),
        ("a='" + "x" * 1_000_000 + "'", "too large"),
        # What ends a string or a comment, and what only seems to.
        (f'a={{b="""x"""", {LONG}=1}}', "nested too deeply"),
        (f"a={{b='''x''''', {LONG}=1}}", "nested too deeply"),
        (f'a="#"\n{LONG}=1', "nested too deeply"),
        (f'a="\\""\n{LONG}=1', "nested too deeply"),
        (f"a='\\'\n{LONG}=1", "nested too deeply"),
        (f'a="""\n#"""\n{LONG}=1', "nested too deeply"),
        (f'# "\n{LONG}=1', "nested too deeply"),
    ],
    ids=lambda text: text[:16],
)
def test_what_would_take_long_is_not_parsed(
    monkeypatch: pytest.MonkeyPatch, text: str, reason: str
) -> None:
    monkeypatch.setattr(tomllib, "loads", None)
    with pytest.raises(ConfigError, match=reason):
        parsed(text)


@pytest.mark.parametrize(
    "text",
    [
        f'a="""\n{LONG}=1\n"""',
        f"a='''\n{LONG}=1\n'''",
        f'a="{LONG}" # {LONG}',
        f"a='{LONG}[[[[' # [[[[",
        "a=" + str([[0.5, 1.5]] * 2000),
        "".join(f"a.b.c{n}=1\n" for n in range(KEYS_MAX)),
        ".".join("a" * DEPTH_MAX) + "=1",
    ],
    ids=lambda text: text[:16],
)
def test_what_takes_no_time_is_parsed(text: str) -> None:
    assert parsed(text) == tomllib.loads(text)


@pytest.mark.parametrize("tail", ['"', '"""', "'''", '"""\\', '"\\', "[", "a."])
def test_a_text_that_breaks_off_is_not_toml(tail: str) -> None:
    with pytest.raises(ConfigError, match="is not TOML"):
        parsed(f"a=1\nb={tail}")


def test_keys_and_brackets_together_are_bounded() -> None:
    text = "a=" + ("{" + ".".join("a" * 5) + "=") * 5 + "1" + "}" * 5
    with pytest.raises(ConfigError, match="nested too deeply"):
        parsed(text)


def test_what_ships_is_far_below_the_bounds() -> None:
    files = sorted(config_root().rglob("*.toml"))
    assert files
    for path in files:
        parse(path, size_max=50_000)


def test_depth_of_tables_and_lists() -> None:
    value: object = 1
    for level in range(DEPTH_MAX):
        value = [value] if level % 2 else {"a": value}
    check_depth(value, loc="body")
    with pytest.raises(ConfigError, match="body: is nested too deeply"):
        check_depth([value], loc="body")


def test_paths_are_bounded_in_depth() -> None:
    for parts in (DEPTH_MAX + 1, 5000):
        path = "plant.x" + ".a" * (parts - 2)
        with pytest.raises(ConfigError, match="has too many parts") as caught:
            load_scenario("circle", {path: 1})
        assert len(str(caught.value)) < 400


def test_many_values_cost_one_look_at_the_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each look copies all tables: one for each value is quadratic."""
    looks = []
    resolve = changes.resolve
    monkeypatch.setattr(changes, "resolve", lambda t: looks.append(1) or resolve(t))
    document = load_scenario("circle").model_dump(mode="json")
    apply_changes(document, {f"plant.x.key{n}": "value" for n in range(1000)})
    assert len(looks) == 1


def test_a_part_is_there_before_what_lies_inside_it() -> None:
    changes = {
        "plant.x.force_map.gain": 1.25,
        "plant.force_map": "new-design",
        "variants.A.controller.x.k_p": 123.0,
        "variants.A.controller": "pd",
    }
    found = load_scenario("circle", changes)
    assert found.plant.x.force_map.gain == 1.25  # type: ignore[union-attr]
    assert found.plant.y.force_map.name == "new-design"  # type: ignore[union-attr]
    assert found.variants["A"].controller.x.k_p == 123.0


def test_many_complaints_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    hints = []
    hint = validation_errors.did_you_mean
    monkeypatch.setattr(validation_errors, "did_you_mean", lambda *a: hints.append(1) or hint(*a))
    with pytest.raises(ConfigError) as caught:
        load_scenario("circle", {f"plant.x.key{n}": "value" for n in range(1000)})
    lines = str(caught.value).splitlines()
    assert len(lines) == SHOWN_MAX + 1
    assert lines[-1] == f"and {1000 - SHOWN_MAX} more"
    assert len(hints) == 10 * SHOWN_MAX


def test_a_long_word_is_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(named_configs.difflib, "get_close_matches", None)
    assert named_configs.did_you_mean("k" * 1000, ["kind"]) == ""


def test_what_is_shown_is_short() -> None:
    deep: list[object] = []
    for _ in range(5000):
        deep = [deep]
    wide = {f"key{n}": ["x" * 1000] * 1000 for n in range(1000)}
    for value in ("x" * 10_000, deep, wide, 10**5000, [10**5000], [[["x"] * 99] * 99] * 99):
        assert len(str(shown(value))) <= 200
        assert len(str(FieldError("x" * 1000, "is wrong", value))) < 500
    for value in (None, True, 1, 1.5, "text"):
        assert shown(value) == value
    assert shown([1, "a"]) == '[1, "a"]'
