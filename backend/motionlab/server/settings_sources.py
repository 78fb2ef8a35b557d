"""Settings of a server by option, environment variable or file, in that order of precedence."""

from __future__ import annotations

import ipaddress
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError
from pydantic.fields import FieldInfo
from pydantic_settings import (
    BaseSettings,
    EnvSettingsSource,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
)

from motionlab.config.named_configs import config_root, data_root, did_you_mean, parse
from motionlab.config.quantity import quantity
from motionlab.config.validation_errors import bounds_of, choices_of, field_errors, unit_of_field
from motionlab.declarations import OURS
from motionlab.errors import ConfigError, FieldError
from motionlab.library.database import index_url
from motionlab.library.files import runs_url
from motionlab.library.quota import QUOTA
from motionlab.server.memory_budget import recordable
from motionlab.server.settings import Bounds

PREFIX = "MOTIONLAB_"
FILE = "MOTIONLAB_SETTINGS"
"""Variable that names the file of settings."""

LogLevel = Literal["debug", "info", "warning", "error", "critical"]

_OTHERS = frozenset({FILE, "MOTIONLAB_SERVER"})  # the second is of `npm run dev`
_OF_TESTS = "MOTIONLAB_TEST_"
_SECRETS = frozenset({"token"})
_BELOW = ("data", "configs", "database_url", "runs_url", "runs_max")
"""Read from the environment by packages that know no server."""

_TOKEN_MIN = 16
_VISIBLE = re.compile("[!-~]+")
_HOST_NAME = re.compile(r"[a-z0-9._-]+|\[[0-9a-f:.]+\]")
_PASSWORD = re.compile(r"(?<=//)([^/@:]*):[^/@]*@")
_QUERY = re.compile(r"(?<=[?&])([^=&]+)=[^&]*")

_SWITCH = {"true": True, "1": True, "yes": True, "false": False, "0": False, "no": False}
_LISTS = {"hosts", "proxies"}  # comma between the parts of a variable; sources add up


class ServerSettings(BaseSettings, Bounds):  # pyright: ignore[reportIncompatibleVariableOverride]
    """Everything that can be set of a server; variables are MOTIONLAB_ and a field's name."""

    model_config = SettingsConfigDict(env_prefix=PREFIX, env_ignore_empty=True)

    host: str = Field(default="127.0.0.1", description="Address to listen on")
    port: int = quantity(
        "Port; 0 takes a free one", unit="1", source=OURS, default=8000, ge=0, le=65_535
    )
    hosts: tuple[str, ...] = Field(
        default=(),
        description="Further host names under which clients reach the server, without port; those "
        "of option, environment and file add up",
    )
    proxies: tuple[str, ...] = Field(
        default=(),
        description="Addresses or networks of proxies whose `X-Forwarded-For` and "
        "`X-Forwarded-Proto` are believed; none unless named",
    )
    token: str | None = Field(default=None, description="What clients must present", repr=False)
    token_file: str | None = Field(default=None, description="File that holds the token")
    log_level: LogLevel = Field(
        default="warning", description="Least level of what is logged; from info on, every request"
    )
    laws: str | None = Field(
        default=None, description="Folders and files of laws of one's own, joined as in PATH"
    )
    studies: str | None = Field(
        default=None,
        description="Folders and files of studies and views of one's own, joined as in PATH",
    )
    edit_laws: bool = Field(
        default=False,
        description="Whether the page may change files of laws of one's own: code that runs here. "
        "On loopback only, and with a token",
    )
    data: str | None = Field(
        default=None, description="Folder of runs, trajectories, jobs and force maps"
    )
    configs: str | None = Field(
        default=None, description="Folder that replaces the shipped configs"
    )
    scheduler: str | None = Field(default=None, description="Where studies are computed")
    drive: str | None = Field(default=None, description="Link to drives, a file or the name of one")
    database_url: str | None = Field(default=None, description="Index of runs")
    runs_url: str | None = Field(default=None, description="Telemetry of runs")
    runs_max: int = quantity(
        "Telemetry of runs", unit="bytes", source=OURS, default=QUOTA, ge=0, le=10**18
    )

    @classmethod
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        *_: PydanticBaseSettingsSource,
        **__: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Take what `load` has read, and nothing else."""
        return (init_settings,)


class _Environment(EnvSettingsSource):
    """The variables, as numbers and lists where the fields are."""

    def prepare_field_value(
        self, field_name: str, field: FieldInfo, value: Any, value_is_complex: bool
    ) -> Any:
        """Return a variable's value; text that is no number is left for validation to refuse."""
        if value is None:
            return None
        if field_name in _LISTS:
            return tuple(name for part in value.split(",") if (name := part.strip()))
        if field.annotation is bool:
            return _SWITCH.get(value.lower(), value)
        if field.annotation in {int, float}:
            for number in (int, float):
                try:
                    return number(value)
                except ValueError:
                    pass
        return value


@dataclass(frozen=True)
class Loaded:
    """Settings, and where they came from.

    Attributes
    ----------
    settings : ServerSettings
        The values in effect; `token` also where a file held it.
    origins : dict of str to str
        By field: the option, the variable, or the file and its key; not of defaults.
    warnings : tuple of str
        Variables that look like settings and are none.
    """

    settings: ServerSettings
    origins: Mapping[str, str]
    warnings: tuple[str, ...]

    def export(self) -> None:
        """Set the variables of the packages that know no server, and remove the token's."""
        values = self.settings.model_dump(include=set(_BELOW))
        os.environ.update(
            {PREFIX + name.upper(): str(values[name]) for name in _BELOW if name in self.origins}
        )
        for name in ("MOTIONLAB_TOKEN", "MOTIONLAB_TOKEN_FILE"):
            os.environ.pop(name, None)  # child processes have no use for them

    def rows(self) -> list[tuple[str, str, str, str, str]]:
        """Return field, value in effect, origin, unit and range of every setting."""
        return [
            (name, self._shown(name), self.origins.get(name, "default"), *unit_and_range(info))
            for name, info in sorted(
                ServerSettings.model_fields.items(),
                key=lambda field: field[0] in Bounds.model_fields,
            )
        ]

    def _shown(self, name: str) -> str:
        value = getattr(self.settings, name)
        if name in _SECRETS:
            return "none" if value is None else "(hidden)"
        if value is None:
            places = {"data": data_root, "configs": config_root}
            root = Path(self.settings.data or data_root())
            inside = {"database_url": index_url, "runs_url": runs_url}
            value = (
                places[name]() if name in places else inside[name](root) if name in inside else ""
            )
        if isinstance(value, tuple):
            value = ",".join(value)
        return _QUERY.sub(r"\1=***", _PASSWORD.sub(r"\1:***@", f"{value}")) or "none"


def load(options: Mapping[str, Any], file: str | None = None) -> Loaded:
    """Return the settings of a server.

    Parameters
    ----------
    options : mapping
        Fields given on the command line; None for those that are not.
    file : str, optional
        TOML file of settings; that of MOTIONLAB_SETTINGS when left out.

    Raises
    ------
    ConfigError
        Naming each option, variable or key that is wrong, its value, range and unit.
    """
    file = file or os.environ.get(FILE)
    of_command = {name: value for name, value in options.items() if value is not None}
    sources = (
        (of_command, lambda name: "--name" if name == "hosts" else f"--{name.replace('_', '-')}"),
        (_Environment(ServerSettings)(), lambda name: PREFIX + name.upper()),
        (parse(Path(file)) if file else {}, lambda name: f"{file}: {name}"),
    )
    values: dict[str, Any] = {}
    origins: dict[str, str] = {}
    for settings, named in sources:
        for name, each in settings.items():
            value = tuple(each) if isinstance(each, list) else each
            if name not in values:
                values[name], origins[name] = value, named(name)
            elif name in _LISTS and isinstance(value, tuple):
                values[name] += value
                origins[name] += f", {named(name)}"
    try:
        settings = ServerSettings(**values)
    except ValidationError as error:
        errors = field_errors(error, ServerSettings)
        raise ConfigError(*(_at_origin(each, origins) for each in errors)) from None
    memory = recordable(settings.memory_max)
    if memory < settings.memory_max:
        origins["memory_max"] = f"{origins.get('memory_max', 'default')}, half of the machine's"
    checked = {"token": _token(settings, origins), "hosts": _names(settings, origins)}
    _check_proxies(settings, origins)
    settings = settings.model_copy(update=checked | {"memory_max": memory})
    return Loaded(settings, origins, _unknown_variables())


def _at_origin(error: FieldError, origins: Mapping[str, str]) -> FieldError:
    """Return an error of a field at the option, variable or key that gave it."""
    name = error.loc.split(".", maxsplit=1)[0]
    value = None if name in _SECRETS else error.value
    return replace(error, loc=origins.get(name, error.loc), value=value)


def _token(settings: ServerSettings, origins: Mapping[str, str]) -> str | None:
    """Return the token, from its file if there is one; errors never show it."""
    token, at = settings.token, origins.get("token", "")
    if settings.token_file is not None:
        at = origins["token_file"]
        if token is not None:
            text = f"is set beside {origins['token']}: remove one of them"
            raise ConfigError(FieldError(at, text, settings.token_file))
        try:
            token = Path(settings.token_file).read_text(encoding="utf-8").strip("\r\n")
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "is not UTF-8 text"
            text = f"cannot be read: {reason}"
            raise ConfigError(FieldError(at, text, settings.token_file)) from None
    if token is not None and len(token) < _TOKEN_MIN:
        raise ConfigError(FieldError(at, "is too short", range=f">= {_TOKEN_MIN} characters"))
    if token is not None and not _VISIBLE.fullmatch(token):
        allowed = "ASCII without blanks and line ends"
        raise ConfigError(FieldError(at, "has a character that no header can carry", range=allowed))
    return token


def _names(settings: ServerSettings, origins: Mapping[str, str]) -> tuple[str, ...]:
    """Return the host names as browsers write them."""
    names = tuple(name.lower() for name in settings.hosts)
    wrong = [name for name in names if not _HOST_NAME.fullmatch(name)]
    rule = "names without scheme, port or path, comma between them"
    if wrong:
        errors = (FieldError(origins["hosts"], "is no host name", name, rule) for name in wrong)
        raise ConfigError(*errors)
    return names


def _check_proxies(settings: ServerSettings, origins: Mapping[str, str]) -> None:
    """Refuse what is no address and no network."""
    wrong = []
    for proxy in settings.proxies:
        try:
            ipaddress.ip_network(proxy)
        except ValueError:
            wrong.append(proxy)
    if wrong:
        rule = "IP addresses or networks such as 172.16.0.0/12, comma between them"
        what = "is no address and no network"
        raise ConfigError(*(FieldError(origins["proxies"], what, one, rule) for one in wrong))


def _unknown_variables() -> tuple[str, ...]:
    known = {PREFIX + name.upper() for name in ServerSettings.model_fields} | _OTHERS
    variables = {name for name in os.environ if name.startswith(PREFIX)}
    unknown = sorted(name for name in variables - known if not name.startswith(_OF_TESTS))
    return tuple(f"{name} is no setting{did_you_mean(name, sorted(known))}" for name in unknown)


def unit_and_range(info: FieldInfo) -> tuple[str, str]:
    """Return the unit of a field, empty for a pure number, and what is allowed, in words."""
    bounds = FieldError("", "", bounds=bounds_of(info)).range
    return unit_of_field(info).removeprefix("1"), choices_of(info) or bounds
