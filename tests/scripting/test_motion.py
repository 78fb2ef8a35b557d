"""Trajectories from Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motionlab

FAST = {"kind": "circle", "radius": 0.02, "frequency": 2.0, "laps": 3}


def test_a_shipped_motion_is_sampled_and_feasible() -> None:
    motion = motionlab.trajectory("circle")
    assert motion.feasible
    assert motion.position.shape == motion.velocity.shape == (len(motion.time), 2)
    run = motionlab.run("circle")
    for axis, name in enumerate("xy"):
        reference = run[f"{name}.position_reference"]
        np.testing.assert_array_equal(reference, motion.position[:, axis].astype(np.float32))
    assert (motion.position.unit, motion.velocity.unit) == ("m", "m/s")


@pytest.mark.filterwarnings("ignore::motionlab.RunWarning")  # PD alone takes more than the motion
def test_what_exceeds_the_motor_says_where_and_how_slow_it_would_have_to_be() -> None:
    motion = motionlab.trajectory(FAST)
    assert not motion.feasible
    worst = motion.check.violations[0]
    assert abs(worst.value) > worst.limit
    slower = motion.slowed()
    assert slower.feasible
    assert slower.check.duration > motion.check.duration
    run = motionlab.run("circle", {"trajectory": slower.table})
    assert len(run.time) == len(slower.time)


def test_files_and_errors(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text('kind = "circle"\nradius = 0.01\nfrequency = 0.5\nlaps = 2\n')
    assert motionlab.trajectory(str(own)).table == motionlab.trajectory(own).table
    with pytest.raises(motionlab.ConfigError, match=r"motion: no .*did you mean 'rhombus'"):
        motionlab.trajectory("rhombos")
    with pytest.raises(motionlab.ConfigError, match=r"motion: cannot be read.*none\.toml"):
        motionlab.trajectory(tmp_path / "none.toml")
    with pytest.raises(motionlab.ConfigError, match="radius"):
        motionlab.trajectory(FAST | {"radius": -1.0})
