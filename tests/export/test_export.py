"""``motionlab export-controller``: the folder, its check, and what is refused."""

from __future__ import annotations

import hashlib
import os
import re
import stat
from pathlib import Path

import pytest

from motionlab.cli import main
from motionlab.export import export
from motionlab.export.export import SOURCE
from motionlab.targets.record_values import RecordError
from tests.export.compilers import SOURCES, STRICT, built, call, compiler
from tests.paths import ROOT

TABLE = [
    f"--set=variants.B.controller.model.{axis}.force_map={{kind='table', name='new-design'}}"
    for axis in "xy"
]
SHARED_BY_LOSS = "--set=variants.B.controller.sharing.law=force-per-ampere"


def exported(folder: Path, *options: str) -> Path:
    assert main(["export-controller", "circle", "-o", str(folder), *options]) == 0
    return folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the export of variant B of the circle with its 10 s of test vectors."""
    return exported(tmp_path_factory.mktemp("circle") / "new", "--variant", "B")


@pytest.fixture(scope="module")
def tabled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an export with tables of both kinds."""
    options = ("--variant", "B", "--seconds", "0.2", *TABLE, SHARED_BY_LOSS)
    return exported(tmp_path_factory.mktemp("tables"), *options)


@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_ten_seconds_of_the_circle_agree(name: str, whole: Path) -> None:
    done = call("make", "-C", whole, "check", f"CC={compiler(name)}", "CFLAGS=-O2 -Werror")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "20000 periods, 0 numbers beyond their tolerance: passed" in done.stdout


@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_it_agrees_optimised_for_the_processor(name: str, whole: Path, tmp_path: Path) -> None:
    """With fused multiplication and addition where the processor has it."""
    sources = [whole / source for source in SOURCES]
    options = ("-std=gnu11", "-O3", "-march=native", "-ffp-contract=fast")
    built(compiler(name), *options, *sources, "-lm", "-o", tmp_path / "check")
    assert call(tmp_path / "check", whole / "vectors.bin").returncode == 0


def test_it_agrees_where_subnormal_numbers_are_flushed(whole: Path, tmp_path: Path) -> None:
    """Linked with -ffast-math, gcc's start-up code sets the mode; the code itself is exact."""
    sources = [whole / source for source in SOURCES]
    built(compiler("gcc"), *STRICT, "-O2", "-c", *sources, cwd=tmp_path)
    objects = sorted(tmp_path.glob("*.o"))
    built(compiler("gcc"), "-ffast-math", *objects, "-lm", "-o", tmp_path / "check")
    assert call(tmp_path / "check", whole / "vectors.bin").returncode == 0


def test_tables_compile_and_agree(tabled: Path) -> None:
    done = call("make", "-C", tabled, "check", f"CC={compiler('gcc')}", "CFLAGS=-O2 -Werror")
    assert done.returncode == 0, done.stdout + done.stderr
    tables = (tabled / "psrm_tables.h").read_text()
    places = re.findall(r"/\* from (\d+): (\w+)", tables)
    assert [quantity for _, quantity in places] == ["thrust", "current", "share"]
    parameters = (tabled / "psrm_parameters.c").read_text()
    for field, (place, _) in zip(("thrust", "inverse", "table"), places, strict=True):
        assert parameters.count(f".{field} = {place}.0,") == 2  # x and y read the same


def test_the_function_of_the_documentation_is_there(whole: Path) -> None:
    page = (ROOT / "docs" / "export-controller.md").read_text()
    (piece,) = re.findall(r"^```c\n(.*?)^```$", page, re.M | re.S)
    assert piece in (whole / "psrm_controller.c").read_text()


def test_lines_fit_a_page(whole: Path, tabled: Path) -> None:
    sources = [*whole.glob("psrm_*"), *tabled.glob("psrm_[cmp]*")]
    assert len(sources) == 8
    for source in sources:
        assert [line for line in source.read_text().splitlines() if len(line) > 100] == []


def test_it_compiles_as_cpp(tabled: Path) -> None:
    sources = [tabled / source for source in SOURCES if source != "check.c"]
    options = ("-x", "c++", "-std=c++20", "-Wall", "-Wextra", "-Wpedantic", "-fsyntax-only")
    built(compiler("g++"), *options, *sources)


def test_snippets_of_its_readme_compile(whole: Path, tmp_path: Path) -> None:
    snippets = re.findall(r"^```c\n(.*?)^```$", (whole / "README.md").read_text(), re.M | re.S)
    assert len(snippets) == 2
    for number, snippet in enumerate(snippets):
        source = tmp_path / f"snippet{number}.c"
        source.write_text(snippet)
        built(compiler("gcc"), *STRICT, "-fsyntax-only", "-I", whole, source)


@pytest.mark.parametrize(
    "slip", [("k_p = 200300.0", "k_p = 200300.0001"), ("M = 5.9", "M = 5.90001")]
)
def test_a_wrong_number_is_found(slip: tuple[str, str], whole: Path, tmp_path: Path) -> None:
    text = (whole / "psrm_parameters.c").read_text()
    assert slip[0] in text
    (tmp_path / "psrm_parameters.c").write_text(text.replace(*slip))
    sources = [whole / source for source in SOURCES if source != "psrm_parameters.c"]
    wrong = tmp_path / "psrm_parameters.c"
    built(compiler("gcc"), "-O2", "-I", whole, *sources, wrong, "-lm", "-o", tmp_path / "check")
    done = call(tmp_path / "check", whole / "vectors.bin")
    assert done.returncode == 1
    assert re.search(r"first at 0\.\d{4} s, axis x, ", done.stdout)


def test_other_vectors_are_refused(whole: Path, tmp_path: Path) -> None:
    sources = [whole / source for source in SOURCES]
    built(compiler("gcc"), "-O2", *sources, "-lm", "-o", tmp_path / "check")
    content = (whole / "vectors.bin").read_bytes()
    for number, part in enumerate([b"", b"x" + content[1:], content[:-8]]):
        file = tmp_path / f"{number}.bin"
        file.write_bytes(part)
        assert call(tmp_path / "check", file).returncode == 2


def test_generated_files_name_scenario_and_version(whole: Path) -> None:
    digest = hashlib.sha256((whole / "scenario.toml").read_bytes()).hexdigest()
    for name in ("psrm_parameters.c", "README.md"):
        assert digest in (whole / name).read_text(), name
    again = whole.parent / "again"
    options = ["--variant", "B", "--seconds", "0.01"]
    scenario = str(whole / "scenario.toml")
    assert main(["export-controller", scenario, "-o", str(again), *options]) == 0
    values = [
        (folder / "psrm_parameters.c").read_text().partition("#include")[2]
        for folder in (whole, again)
    ]
    assert values[0] == values[1]


def test_a_former_export_is_replaced_and_other_files_are_not(tabled: Path, tmp_path: Path) -> None:
    options = ("--variant", "B", "--seconds", "0.01")
    folder = exported(tmp_path / "new", *options, *TABLE)
    assert (folder / "psrm_tables.h").exists()
    exported(folder, *options)
    assert not (folder / "psrm_tables.h").exists()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "Makefile").write_text("mine")
    arguments = ["export-controller", "circle", "-o", str(tmp_path / "other")]
    assert main(arguments) == 2
    assert (tmp_path / "other" / "Makefile").read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--variant", "C"], "--variant = C is no variant of it"),
        (["--seconds", "0"], "--seconds"),
        (["--seconds", "nan"], "--seconds"),
        (["--set", "seed=x"], "seed"),
    ],
)
def test_refusals(
    options: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "new"
    assert main(["export-controller", "circle", "-o", str(folder), *options]) == 2
    assert message.partition(" ")[0] in capsys.readouterr().err
    assert not folder.exists()


@pytest.mark.parametrize(
    ("mask", "folder_mode", "file_mode"), [(0o022, 0o755, 0o644), (7, 0o770, 0o660)]
)
def test_permissions_are_those_of_the_umask(
    mask: int, folder_mode: int, file_mode: int, tmp_path: Path
) -> None:
    before = os.umask(mask)
    try:
        folder = exported(tmp_path / "above" / "new", "--seconds", "0.01")
    finally:
        os.umask(before)
    assert stat.S_IMODE(folder.stat().st_mode) == folder_mode
    assert stat.S_IMODE(folder.parent.stat().st_mode) == folder_mode
    assert {stat.S_IMODE(each.stat().st_mode) for each in folder.iterdir()} == {file_mode}


def test_the_command_that_checks_it_can_be_pasted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = exported(tmp_path / "my $HOME; ls", "--seconds", "0.01")
    assert f"make -C '{folder}' check" in capsys.readouterr().out


def test_a_folder_in_the_place_of_a_file_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = exported(tmp_path / "new", "--seconds", "0.01")
    (folder / "check.c").unlink()
    (folder / "check.c").mkdir()
    assert main(["export-controller", "circle", "-o", str(folder), "--seconds", "0.01"]) == 1
    assert f"{folder / 'check.c'}: cannot be written: Is a directory" in capsys.readouterr().err


def test_the_vectors_end_where_the_schedule_changes_the_controller(tmp_path: Path) -> None:
    changed = "--set=schedule=[{time=0.02, set={'variants.B.controller.x.k_p'=1e5}}]"
    for variant, periods in {"A": "80", "B": "40"}.items():
        folder = exported(tmp_path / variant, "--variant", variant, "--seconds", "0.04", changed)
        assert f"{periods} control periods" in (folder / "README.md").read_text()


def test_only_one_file_includes_the_maths_library() -> None:
    including = [path.name for path in SOURCE.iterdir() if "<math.h>\n" in path.read_text()]
    assert sorted(including) == ["check.c", "psrm_math.h"]


def test_a_law_that_is_not_made_of_lanes_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def not_made(*_: object) -> None:
        raise RecordError("step in a_law: lanes are used as true or false")

    monkeypatch.setattr(export, "controller_code", not_made)
    arguments = ["export-controller", "circle", "-o", str(tmp_path / "new"), "--seconds", "0.01"]
    assert main(arguments) == 2
    loc = "variants.A.controller.compensation.law"
    assert f"{loc}: cannot be written as C: step in a_law: lanes" in capsys.readouterr().err
