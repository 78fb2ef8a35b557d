"""Recorded lane functions give in C what they give in Python."""

from __future__ import annotations

import ctypes
import importlib.util
import itertools
from pathlib import Path
from typing import Any

import pytest

from motionlab.targets.c_program import Program
from motionlab.targets.record import Recorder
from motionlab.targets.record_values import Constant, RecordError
from tests.export.compilers import STRICT, built, compiler
from tests.targets import lane_functions as functions
from tests.targets.lane_functions import Mass, Report, Spring, branching, swing

HEAD = "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n"
WRAPPER = """
void run(const double in[5], double out[6])
{
    const psrm_spring spring = {.stiffness = in[0], .damping = in[1]};
    const psrm_mass start = {.p = in[2], .v = in[3]};
    psrm_mass mass;
    psrm_report report;
    CALL;
    out[0] = mass.p;
    out[1] = mass.v;
    out[2] = report.largest;
    out[3] = report.swapped;
    out[4] = report.far ? 1.0 : 0.0;
    out[5] = report.default_;
}
"""
NUMBERS = list(itertools.product((3.0, 0.5), (0.25,), (-1.5, 2.0), (0.0, 4.0), (1.0, -0.75)))


def program(kind: float = 0.0) -> tuple[Program, str]:
    """Return a program of `swing`, and its text."""
    arguments = {
        "spring": Spring(0.0, 0.0, 0.0),
        "s": Mass(0.0, 0.0, 0.0),
        "kick": 0.0,
        "kind": Constant(kind, structural=True),
    }
    entry = Recorder().record(swing, arguments)
    made = Program({"swing": entry}, states=[Mass])
    names = {"spring": "&spring", "s": "&start", "kick": "in[4]"}
    call = " ".join(line.strip() for line in made.call(entry, names, "&mass", "&report"))
    text = HEAD + made.types(public=True) + made.types(public=False) + made.functions()
    return made, text + WRAPPER.replace("CALL", call)


@pytest.mark.parametrize("kind", [0.0, 1.0])
def test_c_computes_what_python_does(kind: float, tmp_path: Path) -> None:
    (tmp_path / "swing.c").write_text(program(kind)[1])
    options = (*STRICT, "-O1", "-ffp-contract=off", "-shared", "-fPIC")
    built(compiler("gcc"), *options, "swing.c", "-lm", "-o", "swing.so", cwd=tmp_path)
    run: Any = ctypes.CDLL(str(tmp_path / "swing.so")).run
    for numbers in NUMBERS:
        k, d, p, v, kick = numbers
        mass, report = swing(Spring(k, d, 0.0), Mass(p, v, 0.0), kick, kind)
        out = (ctypes.c_double * 6)()
        run((ctypes.c_double * 5)(*numbers), out)
        largest, default, swapped, far = report
        expected = (mass.p, mass.v, largest, swapped, far, default)
        assert list(out) == [float(each) for each in expected], numbers


def test_what_nobody_reads_is_not_there() -> None:
    made, text = program()
    assert made.fields(Spring) == ["stiffness", "damping"]
    assert made.fields(Mass) == ["p", "v"]
    assert made.fields(Report) == list(Report._fields)
    assert "floor(" not in text
    assert "floor(" in program(1.0)[1]


def test_an_interface_keeps_its_fields() -> None:
    spring = {"spring": Spring(0.0, 0.0, 0.0), "s": Mass(0.0, 0.0, 0.0), "kick": 0.0}
    entry = Recorder().record(swing, spring | {"kind": Constant(0.0, structural=True)})
    made = Program({"swing": entry}, states=[Mass], whole=[Spring])
    assert made.fields(Spring) == list(Spring._fields)
    assert made.fields(Mass) == ["p", "v"]


def test_names_comments_and_loops_of_the_source_are_there() -> None:
    text = program()[1]
    for part in (
        "static const double HALF = 0.5; /* of anything */",
        "for (uint32_t k = 0U; k < (uint32_t)TURNS; k++) {",
        "/* kept while its variable changes */",
        "/* Return -(k p + d v), N. */\nstatic double force(const psrm_spring *spring,",
        "    double stiffness; /* N/m */\n",
        "    bool far;        /* beyond 1 m */\n",
        "mass.v)); /* by its old velocity */\n",
        "double_ * HALF",
    ):
        assert part in text, part


def test_a_branch_on_lanes_is_refused() -> None:
    message = r"^branching in tests.targets.lane_functions: line \d+: lanes are"
    with pytest.raises(RecordError, match=message):
        Recorder().record(branching, {"x": 0.0})


def test_what_lanes_cannot_do_is_refused() -> None:
    message = r"^remainder in tests.targets.lane_functions: line \d+: unsupported operand"
    with pytest.raises(RecordError, match=message):
        Recorder().record(functions.remainder, {"x": 0.0})


def test_a_value_from_before_a_loop_needs_a_name_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "late.py").write_text(
        "def late(x, y):\n"
        "    for _ in range(2):\n"
        "        old = (x, y)\n"
        "        x = x + y\n"
        "        y = old[0]\n"
        "    return x + y\n"
    )
    spec = importlib.util.spec_from_file_location("late", tmp_path / "late.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    entry = Recorder().record(module.late, {"x": 0.0, "y": 0.0})
    with pytest.raises(RecordError, match="late: the value that x had before its assignment"):
        Program({"late": entry})


def test_one_recording_for_each_kind_of_arguments() -> None:
    recorder = Recorder()
    first = recorder.record(functions.both, {"x": 0.0, "y": 1.0})
    assert recorder.record(functions.both, {"x": 2.0, "y": 3.0}) is first
    fixed = {"x": Constant(1.0, structural=True), "y": 0.0}
    assert recorder.record(functions.both, fixed) is not first
