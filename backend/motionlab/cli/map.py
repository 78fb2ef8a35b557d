"""The command ``motionlab map``."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.options import add_set
from motionlab.cli.progress import share_done
from motionlab.errors import ConfigError, FieldError

EXAMPLES = """\
examples:
  motionlab map
  motionlab map --preset preview --set g=0.4e-3
  motionlab map --preset reference --out map.json
  motionlab map --json --set tau=8e-3 --set p=4e-3
  motionlab map --fit new-design

Maps are kept under MOTIONLAB_DATA/maps (./data/maps) and found again.
"""


def add(commands: Any) -> None:
    """Add ``motionlab map``."""
    parser = commands.add_parser(
        "map",
        help="compute a force map by finite elements",
        description="Compute co-energy, thrust and normal force of one phase over position and "
        "current, by 2-D nonlinear magnetostatics. The default geometry is the paper's; "
        "docs/maps.md lists the fields.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--preset",
        choices=("preview", "default", "reference"),
        default="default",
        help="preview: a magnetic circuit, at once; default; reference: finer, minutes "
        "(%(default)s)",
    )
    add_set(parser, "change a field of the geometry, SI (repeatable, all applied together)")
    parser.add_argument(
        "--fit",
        metavar="NAME",
        help="instead, fit the analytic map to the table of that name, for a controller's model",
    )
    parser.add_argument("--out", metavar="FILE", help="write the map to FILE, .json")
    parser.add_argument("--json", action="store_true", help="print the map's file on stdout")
    parser.set_defaults(command=_map)


def _map(options: argparse.Namespace) -> int:
    """Carry out ``motionlab map``."""
    if options.fit is not None:
        return _fit(options)
    from motionlab.config.changes import parse_assignments
    from motionlab.design.fem.geometry import geometry
    from motionlab.design.fem.report import report
    from motionlab.store.files import data_root
    from motionlab.store.maps import MapStore, check_target, save
    from motionlab.studies.maps.compute import computed_or_kept

    wanted = geometry(parse_assignments(options.assignments))
    if options.out is not None:
        check_target(options.out)
    store = MapStore(data_root() / "maps")
    with share_done("force map") as progress:
        found, kept = computed_or_kept(store, wanted, options.preset, progress=progress)
    if kept:
        print("motionlab: this map was computed before", file=sys.stderr)
    if options.out is not None:
        save(found, Path(options.out))
    if options.json:
        print(found.text(), end="")
    else:
        print(report(found))
    return DONE


def _fit(options: argparse.Namespace) -> int:
    """Carry out ``motionlab map --fit``."""
    from motionlab.studies.sharing.report import fit_report
    from motionlab.studies.sharing.sharing import fit

    if options.assignments or options.out is not None:
        wrong = "--set" if options.assignments else "--out"
        raise ConfigError(FieldError(wrong, "does not go with --fit, which reads a stored map"))
    found = fit(options.fit)
    print(json.dumps(found.model_dump(), allow_nan=False) if options.json else fit_report(found))
    return DONE
