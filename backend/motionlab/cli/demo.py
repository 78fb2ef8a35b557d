"""The command ``motionlab demo``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from motionlab.errors import DONE


def add(commands: Any) -> None:
    """Add the command."""
    parser = commands.add_parser(
        "demo",
        help="write the lab as a static folder that needs no server",
        description="Write the lab as a folder of files for any static host, at any path: its "
        "what-ifs are computed in the browser. docs/demo.md says what it leaves out.",
        epilog="examples:\n  motionlab demo site\n  python -m http.server --directory site\n",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="new, empty, or an older demo")
    parser.set_defaults(command=_demo)


def _demo(options: argparse.Namespace) -> int:
    from motionlab.server.demo import write_demo

    files = write_demo(options.folder)
    size = sum(path.stat().st_size for path in files)
    print(f"{options.folder}: {len(files)} files, {size / 1e6:.1f} MB")
    return DONE
