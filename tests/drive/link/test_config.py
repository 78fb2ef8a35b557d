"""What a drive link's configuration refuses."""

from __future__ import annotations

from pathlib import Path

import pytest

from motionlab.config.drive import load_drive
from motionlab.config.named_configs import config_root
from motionlab.errors import ConfigError

SHIPPED = (config_root() / "drives" / "virtual.toml").read_text()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("virtual = true", "virtual = false", "link.slow = 4: drives run in real time"),
        ("slow = 4", "slow = 21", "20"),
        ("position_min = -0.0845", "position_min = 0.0845", "is not below"),
        ('phase = "b"', 'phase = "a"', "more than one drive for x a, y a, none for x b, y b"),
        ("current_max = 10.0", "current_max = 30.0", "twice the rated current"),
        ("slow = 4", "slow = 4\nloss = 0.02", "loss = 0.02 s must be below watchdog = 0.02 s"),
    ],
)
def test_it_refuses_what_cannot_be(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "drive.toml"
    text = SHIPPED.replace("port = 34980", "port = 34980\nslow = 4")
    path.write_text(text)
    assert load_drive(path).link.slow == 4
    path.write_text(text.replace(old, new))
    with pytest.raises(ConfigError, match=message):
        load_drive(path)
