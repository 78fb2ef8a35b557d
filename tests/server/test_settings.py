"""Settings of a server by option, variable and file, and what becomes of wrong ones."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from motionlab.cli import main
from motionlab.config import named_configs
from motionlab.errors import ConfigError
from motionlab.library.library import quota
from motionlab.server import serve
from motionlab.server.memory_budget import recordable
from motionlab.server.settings import Bounds, Settings
from motionlab.server.settings_sources import PREFIX, ServerSettings, load

TOKEN = "0123456789abcdef"


@pytest.fixture(autouse=True)
def _no_variables(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in [name for name in os.environ if name.startswith(PREFIX)]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "data"))


def refused(options: dict[str, Any] | None = None, file: Path | None = None) -> list[str]:
    """Return the errors of settings, each as a person reads it."""
    with pytest.raises(ConfigError) as caught:
        load(options or {}, file and str(file))
    return str(caught.value).splitlines()


def written(folder: Path, text: str) -> Path:
    file = folder / "motionlab.toml"
    file.write_text(text)
    return file


def test_an_option_comes_before_a_variable_and_a_variable_before_the_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = written(tmp_path, 'port = 1\nworkers = 3\nsessions_max = 5\nlog_level = "error"')
    monkeypatch.setenv("MOTIONLAB_SETTINGS", str(file))
    monkeypatch.setenv("MOTIONLAB_PORT", "2")
    monkeypatch.setenv("MOTIONLAB_WORKERS", "4")
    monkeypatch.setenv("MOTIONLAB_LOG_LEVEL", "")  # as compose passes what is not set
    loaded = load({"port": 7, "host": None})
    found = loaded.settings
    assert (found.port, found.workers, found.sessions_max) == (7, 4, 5)
    assert (found.host, found.log_level) == ("127.0.0.1", "error")
    assert loaded.origins["port"] == "--port"
    assert loaded.origins["workers"] == "MOTIONLAB_WORKERS"
    assert loaded.origins["sessions_max"] == f"{file}: sessions_max"
    assert "host" not in loaded.origins


@pytest.mark.parametrize("name", Bounds.model_fields)
def test_every_bound_can_be_set_and_has_a_unit_and_a_range(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    info = Bounds.model_fields[name]
    assert info.description
    wanted = info.default - 1
    monkeypatch.setenv(PREFIX + name.upper(), f"{wanted:g}" if wanted < 1e5 else f"{wanted:.0f}")
    expected = recordable(wanted) if name == "memory_max" else wanted
    assert getattr(load({}).settings, name) == expected
    monkeypatch.setenv(PREFIX + name.upper(), "-1")
    (line,) = refused()
    assert line.startswith(f"MOTIONLAB_{name.upper()}: is out of range; got -1; allowed >= ")
    assert " and <= " in line


def test_the_application_is_given_what_was_set(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Settings] = []

    def create(settings: Settings) -> None:
        made.append(settings)
        raise RuntimeError("made")

    monkeypatch.setattr(serve, "create_app", create)
    monkeypatch.setattr(serve, "_keep_freed_memory", lambda: None)
    monkeypatch.setenv("MOTIONLAB_HOSTS", "one.example, Two.Example")
    monkeypatch.setenv("MOTIONLAB_TOKEN", TOKEN)
    monkeypatch.setenv("MOTIONLAB_JOBS_MAX", "3")
    with pytest.raises(RuntimeError, match="made"):
        main(["serve", "--port", "0", "--name", "three.example"])
    (settings,) = made
    assert settings.hosts >= {"127.0.0.1", "one.example", "two.example", "three.example"}
    assert (settings.token, settings.jobs_max) == (TOKEN, 3)
    assert (settings.bounds.token, settings.bounds.jobs_max) == (None, 3)
    assert "MOTIONLAB_TOKEN" not in os.environ


def test_what_other_packages_read_is_handed_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("MOTIONLAB_RUNS_MAX", "1")  # restored when the test is over
    monkeypatch.delenv("MOTIONLAB_RUNS_MAX")
    file = written(tmp_path, "runs_max = 123")
    load({"data": str(tmp_path / "mine")}, str(file)).export()
    assert named_configs.data_root() == tmp_path / "mine"
    assert quota() == 123


def test_wrong_keys_of_a_file(tmp_path: Path) -> None:
    file = written(tmp_path, 'prot = 1\nport = 70000\nworkers = true\nlog_level = "loud"\n')
    lines = sorted(line.removeprefix(f"{file}: ") for line in refused(file=file))
    assert lines[0] == (
        "log_level: is not one of the choices; got 'loud'; "
        "allowed one of debug, info, warning, error, critical"
    )
    assert lines[1] == "port: is out of range; got 70000; allowed >= 0 and <= 65535"
    assert lines[2].startswith("prot: unknown key, did you mean 'port'?; got 1; allowed one of ")
    assert lines[3] == "workers: must be a whole number; got true; allowed >= 1 and <= 256"


@pytest.mark.parametrize(
    ("text", "reason"), [(None, "cannot be read: No such file"), ("port 1", "is not TOML")]
)
def test_a_file_that_cannot_be_used(tmp_path: Path, text: str | None, reason: str) -> None:
    file = tmp_path / "motionlab.toml" if text is None else written(tmp_path, text)
    (line,) = refused(file=file)
    assert str(file) in line
    assert reason in line


def test_variables_that_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLAB_PORT", "eight")
    monkeypatch.setenv("MOTIONLAB_DIRECT_MAX", "nan")
    assert sorted(refused()) == [
        "MOTIONLAB_DIRECT_MAX: must be a finite number; got nan; allowed >= 0 and <= 1000000 s",
        "MOTIONLAB_PORT: must be a whole number; got 'eight'; allowed >= 0 and <= 65535",
    ]


def test_a_variable_of_a_mistyped_name_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLAB_SESSION_MAX", "1")
    monkeypatch.setenv("MOTIONLAB_SERVER", "http://127.0.0.1:8000")
    told = "MOTIONLAB_SESSION_MAX is no setting, did you mean 'MOTIONLAB_SESSIONS_MAX'?"
    assert load({}).warnings == (told,)


# -- the token ------------------------------------------------------------------------------------


def test_a_token_in_a_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_text(f"{TOKEN}\n")
    assert load({"token_file": str(file)}).settings.token == TOKEN
    monkeypatch.setenv("MOTIONLAB_TOKEN_FILE", str(file))
    assert load({}).settings.token == TOKEN
    monkeypatch.setenv("MOTIONLAB_TOKEN", "another one, of some length")
    (line,) = refused()
    assert line.startswith(
        "MOTIONLAB_TOKEN_FILE: is set beside MOTIONLAB_TOKEN: remove one of them"
    )


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (None, "cannot be read: No such file"),
        (b"brief", "is too short"),
        (b"\xff" * 16, "cannot be read: is not UTF-8"),
        (b"a word and another", "no header can carry"),
    ],
)
def test_a_file_that_holds_no_token(tmp_path: Path, content: bytes | None, reason: str) -> None:
    file = tmp_path / "token"
    if content is not None:
        file.write_bytes(content)
    (line,) = refused({"token_file": str(file)})
    assert line.startswith("--token-file: ")
    assert reason in line
    assert "another" not in line


def test_a_token_of_the_wrong_kind_is_not_shown(tmp_path: Path) -> None:
    (line,) = refused(file=written(tmp_path, "token = 123456789123456789"))
    assert "token: must be text" in line
    assert "123456789" not in line


# -- what is shown --------------------------------------------------------------------------------


def test_all_settings_in_effect_are_printed_but_no_secret(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MOTIONLAB_TOKEN", TOKEN)
    monkeypatch.setenv("MOTIONLAB_DATABASE_URL", "postgresql://lab:hunter2@db/runs")
    monkeypatch.setenv("MOTIONLAB_SESION_MAX", "1")
    assert main(["serve", "--show-settings", "--port", "8123"]) == 0
    out, err = capsys.readouterr()
    rows = [line.split() for line in out.splitlines()]
    assert [row[0] for row in rows[1:]] == sorted(
        ServerSettings.model_fields, key=lambda name: name in Bounds.model_fields
    )
    assert ["port", "8123", "--port", ">=", "0", "and", "<=", "65535"] in rows
    assert ["direct_max", "300.0", "default", "s", ">=", "0", "and", "<=", "1000000"] in rows
    assert ["token", "(hidden)", "MOTIONLAB_TOKEN"] in rows
    assert ["database_url", "postgresql://lab:***@db/runs", "MOTIONLAB_DATABASE_URL"] in rows
    assert TOKEN not in out + err
    assert "did you mean 'MOTIONLAB_SESSIONS_MAX'" in err


def test_the_bounds_fit_their_types() -> None:
    """A default that its own range refuses would only be seen by who sets it."""
    for name, info in Bounds.model_fields.items():
        assert Bounds(**{name: info.default}) == Bounds()


# -- the folder of the data -----------------------------------------------------------------------


def test_where_the_data_are(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("MOTIONLAB_DATA")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))
    elsewhere = tmp_path / "elsewhere"
    (elsewhere / "data").mkdir(parents=True)  # of somebody's own
    monkeypatch.chdir(elsewhere)
    assert named_configs.data_root() == tmp_path / "home" / "motionlab"
    (elsewhere / "data" / named_configs.SERVER_LOCK).touch()
    assert named_configs.data_root() == Path("data")
    checkout = tmp_path / "checkout"
    checkout.mkdir()
    monkeypatch.chdir(checkout)
    monkeypatch.setattr(named_configs, "_PACKAGE", checkout / "backend" / "motionlab")
    assert named_configs.data_root() == Path("data")


# -- the page in the browser ----------------------------------------------------------------------


@pytest.mark.parametrize("outcome", [True, False, serve.webbrowser.Error("none")])
def test_the_page_opens_where_there_is_a_browser(
    outcome: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[str] = []

    def open_page(page: str) -> bool:
        asked.append(page)
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    monkeypatch.setattr(serve.webbrowser, "open", open_page)
    serve._open("http://127.0.0.1:8000/")
    assert asked == ["http://127.0.0.1:8000/"]
    assert ("no browser" in capsys.readouterr().err) == (outcome is not True)
