"""A trajectory, sampled and checked against the motor that is to follow it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.includes import resolve
from motionlab.config.load import epochs, load_scenario, validate_trajectory
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, FieldError, naming_extras
from motionlab.exchange.paths.reading import (
    SAMPLES_BYTES_MAX,
    ReadOptions,
    read_trajectory,
)
from motionlab.exchange.paths.samples import SUFFIXES, table_of, table_of_file
from motionlab.executors.progress import first_use
from motionlab.library.trajectories import trajectory_table
from motionlab.scripting.arguments import Changes, Source, changes_of, readable, tables
from motionlab.scripting.channels import Samples
from motionlab.simulation.prepare import limit_sets, planned
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.reference import sample
from motionlab.trajectories.retiming import slow_down
from motionlab.trajectories.trajectory_check import Examination, examine

_BINS = 1000


class Trajectory:
    """A sampled motion, and its demands on a motor.

    Attributes
    ----------
    config : TrajectoryConfig
        The motion; ``set={"trajectory": motion.table}`` has a scenario follow it.
    time : Samples, shape (ticks,)
        s.
    position, velocity, acceleration : Samples, shape (ticks, 2)
        Reference of x and y, m, m/s, m/s^2.
    check : Examination
        ``feasible``, ``violations`` with time, place, value and limit, ``peaks`` and their shares
        of the limits.
    """

    def __init__(self, config: TrajectoryConfig, limits: Any) -> None:
        reference = sample(config)
        self.config = config
        self.time = Samples(np.arange(reference.ticks) * CONTROL_PERIOD, "time", "s")
        self.position = Samples(reference.position, "position", "m")
        self.velocity = Samples(reference.velocity, "velocity", "m/s")
        self.acceleration = Samples(reference.acceleration, "acceleration", "m/s^2")
        self.check: Examination = examine(config, limits, bins=_BINS)
        self._limits = limits

    @property
    def table(self) -> dict[str, Any]:
        """The motion as a table of a scenario."""
        return self.config.model_dump(mode="json", exclude_none=True)

    @property
    def feasible(self) -> bool:
        """Whether the motor can follow with every controller."""
        return self.check.feasible

    @property
    def notes(self) -> list[str]:
        """What a user must know of the motion, such as that a faster one may exist."""
        return self.check.notes

    def slowed(self) -> Trajectory:
        """Return the motion just as much slower as makes it feasible.

        Raises
        ------
        Infeasible
            If it leaves the stroke, or jumps: no stretch of time helps.
        """
        return Trajectory(slow_down(self.config, self._limits)[0], self._limits)

    def __repr__(self) -> str:
        """Return a line about the motion."""
        word = "feasible" if self.feasible else f"{self.check.violation_count} limits exceeded"
        return f"<Trajectory {self.config.kind}: {self.check.duration:.4g} s, {word}>"


@first_use()
@naming_extras("trajectory")
def trajectory(
    motion: str | Path | Mapping[str, Any] | NDArray[Any],
    scenario: Source = "circle",
    set: Changes = None,
) -> Trajectory:
    """Sample a motion every 0.5 ms, and check whether the motor of a scenario can follow it.

    Parameters
    ----------
    motion : str, Path, mapping or ndarray
        Name of a shipped or saved trajectory, a ``.toml``, ``.npy``, ``.parquet`` or ``.csv``
        file, or a table such as ``{"kind": "circle", "radius": 0.02, "frequency": 0.5, "laps": 3}``
        or ``{"kind": "samples", "run": "r-..."}``. An array has rows of time, x and y, or of x and
        y every 0.5 ms, in s and m; it and files other than ``.toml`` keep their times.
    scenario, set
        Whose motor and controllers; as of `motionlab.run`.

    Raises
    ------
    ConfigError
        Naming every field that is wrong.
    """
    config = validate_trajectory(_table(motion))
    changes = {"trajectory": config.model_dump(mode="json"), **changes_of(set)}
    follows = planned(load_scenario(readable(scenario), changes))
    return Trajectory(follows.trajectory, limit_sets(epochs(follows)))


def _of_csv(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            content = file.read(SAMPLES_BYTES_MAX + 1)
    except OSError as error:
        text = f"cannot be read: {error.strerror}"
        raise ConfigError(FieldError("motion", text, str(path))) from None
    options = ReadOptions(format="csv", unit="m", samples=True)
    return read_trajectory(content, options).trajectory.model_dump(mode="json")


def _table(motion: str | Path | Mapping[str, Any] | NDArray[Any]) -> dict[str, Any]:
    if isinstance(motion, Mapping):
        return resolve({"trajectory": tables(motion, "motion")})["trajectory"]
    if isinstance(motion, np.ndarray):
        return table_of(motion, "motion")
    if not isinstance(motion, str | Path):
        kinds = "a name, a file, a table or an array"
        raise ConfigError(FieldError("motion", f"must be {kinds}", motion))
    path = Path(motion)
    if path.suffix in SUFFIXES:
        return table_of_file(path, "m", "motion")
    if path.suffix == ".csv":
        return _of_csv(path)
    return trajectory_table(str(motion), "motion")
