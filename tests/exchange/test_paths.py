"""Files of other programs: true to their formulas, refused with their line, written and read."""

import cmath
import math
import re

import numpy as np
import pytest
from scipy.spatial import KDTree
from svg.path import parse_path

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import validate_trajectory
from motionlab.config.trajectory import Sequence
from motionlab.errors import ConfigError
from motionlab.exchange.paths.reading import BYTES_MAX, ReadOptions, read_trajectory
from motionlab.exchange.paths.writing import path_of, write_trajectory
from motionlab.trajectories.drawn_motion import curve_of
from motionlab.trajectories.reference import sample

TOLERANCE = 5e-6
ROUNDING = 2e-9


def read(text: str, **options) -> DrawnPath:
    found = read_trajectory(text.encode(), ReadOptions(**options))
    assert isinstance(found.trajectory, DrawnPath)
    assert found.deviation <= options.get("tolerance", TOLERANCE)
    return found.trajectory


def along(path: DrawnPath, count: int = 4001) -> np.ndarray:
    curve = curve_of(path)
    return curve.path(np.linspace(0.0, curve.length * (1 - 1e-12), count))[0]


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Return the largest distance of places of one curve from the chords of the other."""
    a, way = other[:-1], np.diff(other, axis=0)
    square = np.maximum((way**2).sum(axis=1), 1e-300)

    def from_chords(places: np.ndarray, chords: np.ndarray | slice) -> np.ndarray:
        off = places - a[chords]
        share = np.clip((off * way[chords]).sum(axis=-1) / square[chords], 0.0, 1.0)
        return np.linalg.norm(off - share[..., None] * way[chords], axis=-1)

    # No place is further away than from the chords at the nearest corner. Those that may be the
    # furthest come first; the rest need not be compared with every chord.
    corner = np.asarray(KDTree(other).query(one)[1])
    beside = np.clip(corner[:, None] + [-1, 0], 0, len(way) - 1)
    at_most = from_chords(one[:, None], beside).min(axis=1)
    worst = 0.0
    for k in np.argsort(-at_most):
        if at_most[k] <= worst:
            break
        worst = max(worst, from_chords(one[k], slice(None)).min())
    return worst


def equal_curves(path: DrawnPath, expected: np.ndarray, slack: float = TOLERANCE) -> None:
    found = along(path)
    assert apart(expected[::7], found) < slack + 1e-7
    assert apart(found[::7], expected) < slack + 1e-7


QUARTER = np.linspace(0.0, math.pi / 2, 400)
ROUNDED = np.concatenate(
    [
        [[0.0, 0.0], [0.02, 0.0]],
        np.c_[0.02 + 0.01 * np.sin(QUARTER), 0.01 - 0.01 * np.cos(QUARTER)],
        [[0.03, 0.025]],
    ]
)


@pytest.mark.parametrize(
    "program",
    [
        "G21 G90\nG1 X20 F600\nG3 X30 Y10 I0 J10\nG1 Y25\nM2",
        "g21g91\ng1x20f600\ng3x10y10i0j10\ng1y15",
        "G90 G1 X20 F600\nG03 X30 Y10 R10\nG01 Y25",
        "G90.1 G1 X20 F600\nG3 X30 Y10 I20 J10\nG1 Y25",
        "%\nN10 G20 (inches) G17\nN20 G1 X.787401575 F23.62 ; feed\nG3 X1.181102362 Y.393700787 "
        "I0 J.393700787\nG1 Y.984251969\nM30\n%",
        "G0 X0 Y0 Z5\nM3 S100\nG1 Z-1\nX20 F600\nG3 X30 Y10 J10 I0 Z-2\nG1 Y25\nM5",
    ],
    ids=["absolute", "relative", "radius", "absolute centres", "inches", "ignored words"],
)
def test_conventions_of_g_code_are_one_curve(program: str) -> None:
    path = read(program)
    equal_curves(path, ROUNDED)
    if "F" in program.upper():
        assert path.v_max == pytest.approx(0.01, rel=1e-3)


@pytest.mark.parametrize(
    ("word", "angle"), [("G2 X10 Y10 R-10", -1.5 * math.pi), ("G3 X10 Y10 R-10", 1.5 * math.pi)]
)
def test_a_negative_radius_takes_the_long_way(word: str, angle: float) -> None:
    path = read(f"G0 X0 Y0\n{word} F600")
    assert curve_of(path).length == pytest.approx(0.01 * abs(angle), rel=1e-4)
    center = (0.0, 0.01) if angle < 0 else (0.01, 0.0)
    assert np.hypot(*(along(path) - center).T) == pytest.approx(0.01, abs=TOLERANCE)


def test_a_full_circle_and_a_rapid_move_between_two() -> None:
    found = read_trajectory(b"G0 X10\nG2 I-10 F600\nG0 X50\nG2 I-10\n", ReadOptions())
    assert found.moves == 1
    path = found.trajectory
    assert isinstance(path, DrawnPath)
    assert curve_of(path).length == pytest.approx(0.04 * math.pi + 0.04, rel=1e-4)


def test_dwells_make_a_sequence_and_equal_ones_everywhere_the_dwell() -> None:
    found = read_trajectory(b"G1 X10 F600\nG4 P0.5\nG1 Y10\n", ReadOptions()).trajectory
    assert isinstance(found, Sequence)
    assert [part.kind for part in found.parts] == ["path", "dwell", "path"]
    path = read("G4 P0.5\nG1 X10 F600\nG4 P0.5\nG1 Y10\nG4 P0.5\n")
    assert path.dwell == 0.5


DATA = [
    "M 10 -5 C 20 -5 30 10 5 20 S -10 40 -20 20",
    "m 0 0 q 10 20 30 0 t 30 10",
    "M 0 0 A 25 10 30 1 0 30 10 a 8 8 0 0 1 10 10",
    "M0,0L30 0 30 20H5V3l-3 -1z",
    "M0 0a20 10 0 0120 10",
]


@pytest.mark.parametrize("data", DATA)
@pytest.mark.parametrize(
    ("transform", "matrix"),
    [
        ("", np.eye(3)),
        ("rotate(30) scale(1,-0.5)", None),
        ("skewX(30) translate(3 4)", None),
        ("matrix(1 .5 -.3 .8 2 3)", np.array([[1, -0.3, 2], [0.5, 0.8, 3], [0, 0, 1]])),
    ],
)
def test_svg_paths_are_those_of_another_parser(data: str, transform: str, matrix) -> None:
    if transform.startswith("rotate"):
        z = cmath.exp(1j * math.pi / 6)
        matrix = np.array([[z.real, -z.imag, 0], [z.imag, z.real, 0], [0, 0, 1]])
        matrix = matrix @ np.diag([1, -0.5, 1])
    elif transform.startswith("skewX"):
        matrix = np.array([[1, math.tan(math.pi / 6), 0], [0, 1, 0], [0, 0, 1]])
        matrix = matrix @ np.array([[1, 0, 3], [0, 1, 4], [0, 0, 1]])
    body = f'<g transform="{transform}"><path d="{data}"/></g>'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="100mm" viewBox="-50 -50 100 100">{body}'
    path = read(text + "</svg>")
    places = [s.point(t) for s in parse_path(data)[1:] for t in np.linspace(0, 1, 1000)]
    flat = np.array([[p.real, p.imag, 1.0] for p in places]) @ matrix.T
    equal_curves(path, flat[:, :2] * (1e-3, -1e-3))


def test_a_subpath_may_begin_where_one_was_closed() -> None:
    again = read('<svg><path d="M1 1h9v9z l-5 0 0-5z z"/></svg>')
    moved = read('<svg><path d="M1 1h9v9z M1 1l-5 0 0-5z"/></svg>')
    assert again.points == moved.points


def test_shapes_units_and_what_is_left_out() -> None:
    text = (
        '<svg width="2in" height="1in" viewBox="0 0 20 10"><defs><circle id="c" r="2"/></defs>'
        '<clipPath><rect width="9" height="9"/></clipPath><text>no</text>'
        '<rect style="fill:red;display:none" width="5" height="5"/><use href="#c" x="5" y="3"/>'
        "</svg>"
    )
    found = read_trajectory(text.encode(), ReadOptions())
    assert found.moves == 0
    assert any("text" in note for note in found.notes)
    assert isinstance(found.trajectory, DrawnPath)
    radii = np.hypot(*(along(found.trajectory) - (12.7e-3, -7.62e-3)).T)
    assert radii == pytest.approx(5.08e-3, abs=TOLERANCE)


@pytest.mark.parametrize(
    "table",
    [
        "x [mm],y [mm]\n0,0\n10,0\n10,20\n",
        "# points\nt_ms;x_cm;y/mm;force\n0;0;0;1\n5;1,0;0;2\n10;1,0;20,0;3\n",
        "0.01\t0.0\n0.02\t0.0\n0.02\t0.02\n",
        '"y","x"\n0,0\n0,10\n20,10\n',
    ],
)
def test_tables_of_points(table: str) -> None:
    path = read(table, unit="m" if "0.01\t" in table else "mm")
    shift = 0.01 if "0.01\t" in table else 0.0
    expected = np.array([[shift, 0], [shift + 0.01, 0], [shift + 0.01, 0.02]])
    assert np.array(path.points) == pytest.approx(expected)
    if "t_ms" in table:
        assert path.lap_time == pytest.approx(0.01)


REFUSED = [
    ("G1 X1\nG5 X2", "line 2: .*G5"),
    ("G1 X1\nX2 A3", "line 2: .*A3"),
    ("G1 X1\nG1 Xfoo", "line 2: cannot be read"),
    ("X5 G21", "line 1: comes before any of G0"),
    ("G18 G1 X1", "line 1: .*G18"),
    ("G1 X10\nG2 X20 R1", "line 2: R is too small"),
    ("G1 X10\nG2 X10 R5", "line 2: is a full circle by R"),
    ("G1 X10\nG2 X20 I1 J0", "line 2: is no arc"),
    ("G1 X10\nG2 X10 I0 J0", "line 2: is an arc of radius zero"),
    ("G1 X" + "9" * 29, "line 1: X is out of range"),
    ("G1 X1 (never closed", "line 1: cannot be read"),
    ("G0 X1\nG0 X2", "line 2: .*nothing was drawn"),
    ("G0 G1 X1", "line 1: contradicts G0"),
    ("0,0\n1,nan", "line 2: y is no finite number"),
    ("0,0\n1,1e999", "line 2: y is no finite number"),
    ("0,0\n\n1", "line 3: has another number of cells"),
    ("t,x,y\n0,0,0\n0,1,1", "line 3: has a time that is not after that of line 2"),
    ("a,b\n1,2", "line 1: is neither numbers nor a header"),
    ("x [furlong],y\n1,2\n3,4", "line 1: has a unit"),
    ("5,5\n5,5", "has no way"),
    ("<svg>\n<path d='M0 0 L1'/></svg>", "line 2: path lacks a number"),
    ("<svg>\n<path d='L0 0 1 1'/></svg>", "line 2: path does not begin with M"),
    ("<svg>\n<path d='M0 0 1e99 1'/></svg>", "line 2: path has a number out of range"),
    ("<svg>\n<g transform='rotate(nan)'/></svg>", "line 2: transform"),
    ("<svg>\n<use id='a' href='#a'/></svg>", "line 2: uses itself"),
    ("<svg>\n<use href='other.svg#a'/></svg>", "line 2: refers to another file"),
    ("<!DOCTYPE svg [<!ENTITY a SYSTEM '/a'>]>\n<svg>&a;</svg>", "line 2: .* another file"),
    (
        "<!DOCTYPE svg [<!ENTITY a '&b;'><!ENTITY b SYSTEM '/b'>]>\n<svg id='&a;'/>",
        "line 2: uses an entity that lies in another file",
    ),
    (
        "<!DOCTYPE svg [<!ENTITY a '&b;&b;'><!ENTITY b '" + "c" * 60_000 + "'>]>\n<svg>&a;</svg>",
        "line 2: uses an entity that expands too far",
    ),
    ("<!DOCTYPE svg [<!ENTITY a '&a;'>]>\n<svg>&a;</svg>", "line 2: .* expands too far"),
    ("<svg>\n<g></svg>", "line 2: is no XML"),
    ("<html/>", "line 1: begins no SVG"),
    ("<svg>" + "<g>" * 70, "nested too deeply"),
    ("<svg>\n<path/></svg>", "line 2: draws nothing"),
    ("<svg>\n<path d='M0 0 1 1" + "z" * 100_000 + "'/></svg>", "line 2: .*100000 segments"),
    ("x" + " " * 9000 + "mm" + " " * 9000 + "!,y\n0,0\n1,1", "line 1: is neither numbers"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_what_cannot_be_read_is_refused_with_its_line(text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        read(text)


def test_hostile_files_are_refused() -> None:
    groups = "".join(
        f'<g id="g{k}">' + f'<use href="#g{k - 1}"/>' * 10 + "</g>" for k in range(1, 10)
    )
    laughs = f'<svg><path id="g0" d="M0 0 1 1"/>{groups}</svg>'
    used = '<use href="#a"/>' * 100
    long = f'<svg><path id="a" d="M0 0{"l1 1" * 1000}"/>{used}</svg>'
    for content, message in (
        (laughs.encode(), "repeats too much"),
        (long.encode(), "repeats too much; .*100000 segments"),
        (b"G1 X1\n\xff\xfe\x00", "line 2: is no text"),
        (b"0,0\n1,\x00", "line 2: is no text"),
        (b"0,1\n" * (BYTES_MAX // 4 + 1), "is too large"),
        (b"", "line 1"),
    ):
        with pytest.raises(ConfigError, match=message):
            read_trajectory(content, ReadOptions())


def test_placement_is_asked_for() -> None:
    far = "0,0\n5000,0\n5000,9000\n"
    with pytest.raises(ConfigError, match="too far from mid-stroke"):
        read(far)
    places = np.array(read(far, placement="fit").points)
    assert np.abs(places).max(axis=0) == pytest.approx([0.95 * 0.145 * 5 / 9, 0.95 * 0.145])
    centred = np.array(read("10,10\n20,10\n20,40\n", placement="centre").points)
    assert centred.min(axis=0) == pytest.approx(-centred.max(axis=0))


def test_text_has_the_height_of_its_capitals() -> None:
    found = read_trajectory(b"HI\nH", ReadOptions(format="text", height=0.021))
    assert isinstance(found.trajectory, DrawnPath)
    places = np.array(found.trajectory.points)
    assert places[:, 1].max() == pytest.approx(0.021)
    assert places[:, 1].min() == pytest.approx(-0.034)
    with pytest.raises(ConfigError, match="line 2: has a character at column 1"):
        read("a\n\u00e9", format="text")


def test_five_thousand_segments_come_in() -> None:
    angle = np.arange(5001) * 2 * math.pi / 5000
    rows = zip(40 * np.cos(angle), 60 * np.sin(angle), strict=True)
    found = read_trajectory(
        "".join(f"G1X{x:.5f}Y{y:.5f}\n" for x, y in rows).encode(), ReadOptions()
    )
    assert found.segments == 5001
    assert found.points < 300
    rng = np.random.default_rng(3)
    rows = rng.uniform(-80, 80, (5000, 2))
    found = read_trajectory(
        "".join(f"G1X{x:.3f}Y{y:.3f}\n" for x, y in rows).encode(), ReadOptions()
    )
    assert 5000 <= found.points <= 6000


TRAJECTORIES = [
    {"kind": "circle", "radius": 0.02, "frequency": 1.0, "laps": 2},
    {"kind": "star", "circumradius": 0.03, "frequency": 0.2},
    {"kind": "sine", "amplitude": {"x": 0.02, "y": 0.01}, "phase": {"y": 1.0}, "frequency": 1.0},
    {
        "kind": "path",
        "points": [[0.03, 0], [0, 0.03], [-0.03, 0], [0, -0.02]],
        "closed": True,
        "geometry": "spline",
        "corners": [1],
        "v_max": 0.1,
        "a_max": 1.0,
    },
]


@pytest.mark.parametrize("table", TRAJECTORIES, ids=lambda table: table["kind"])
def test_what_is_written_is_read_again(table: dict) -> None:
    trajectory = validate_trajectory(table)
    written = along(path_of(trajectory))
    slack = TOLERANCE + 2e-6
    for format in ("csv", "svg", "gcode"):
        again = along(read(write_trajectory(trajectory, format)))
        assert apart(again[::7], written) < slack, format
        assert apart(written[::7], again) < slack, format


def test_csv_has_every_tick() -> None:
    trajectory = validate_trajectory(TRAJECTORIES[0])
    rows = write_trajectory(trajectory, "csv").splitlines()[1:]
    reference = sample(trajectory)
    assert len(rows) == reference.ticks + 1
    t, x, y = (float(cell) for cell in re.split(",", rows[777]))
    assert t == pytest.approx(777 * 0.5e-3)
    assert (x * 1e-3, y * 1e-3) == pytest.approx(reference.position[777], abs=ROUNDING)


def test_a_motion_beyond_the_range_of_paths_is_refused() -> None:
    far = {"kind": "circle", "radius": 0.5, "center": {"x": 0.9}, "frequency": 0.1}
    with pytest.raises(ConfigError, match="leaves the range of a path"):
        write_trajectory(validate_trajectory(far), "svg")
