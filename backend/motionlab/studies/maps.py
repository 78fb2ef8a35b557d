"""Force maps by finite elements."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING, Any

from motionlab.errors import ConfigError, FieldError
from motionlab.executors.progress import shows_progress
from motionlab.studies.study import RequestLimits, Study, StudyCommand, lazy

if TYPE_CHECKING:
    from motionlab.motor_design.fem.document import MapRequest
    from motionlab.motor_design.fem.force_map import ForceMap

_EXAMPLES = """\
examples:
  motionlab map
  motionlab map --preset preview --set g=0.4e-3
  motionlab map --preset reference --out map.json
  motionlab map --json --set tau=8e-3 --set p=4e-3
  motionlab map --fit new-design

Maps are kept in the folder maps of the data, MOTIONLAB_DATA, and found again.
"""


class MapStudy(Study):
    """Compute a force map as a job; one that was computed before is answered at once."""

    kind = "map"
    path = "/maps"
    operation = "computeMap"
    tag = "maps"
    report_name = "MapJob"
    request_model = lazy("motor_design.fem.document:MapRequest")
    document_model = lazy("motor_design.fem.document:MapEntry")
    run = lazy("motor_design.computed_maps:run")
    document = lazy("motor_design.computed_maps:document")
    report = lazy("motor_design.fem.report:report")
    suffixes = (".json",)
    write = lazy("motor_design.kept_maps:save")
    bodies = ({"preset": "default", "geometry": {"g": 0.4e-3}},)
    keeps = True
    scatters = True
    command = StudyCommand(
        name="map",
        help="compute a force map by finite elements",
        description="Compute co-energy, thrust and normal force of one phase over position and "
        "current, by 2-D nonlinear magnetostatics. The default geometry is the paper's; "
        "`motionlab docs maps` lists the fields.",
        examples=_EXAMPLES,
        scenario=None,
        set="change a field of the geometry, SI (repeatable, all applied together)",
        title="force map",
    )

    def excess(self, plan: MapRequest, bounds: RequestLimits) -> list[FieldError]:
        """Bound the nodes of the mesh."""
        from motionlab.motor_design.computed_maps import too_many_nodes

        return too_many_nodes(plan.geometry, plan.preset, bounds.map_vertices_max)

    def kept(self, plan: MapRequest) -> ForceMap | None:
        """Return the map that was computed before, or refuse another where there is no room."""
        from motionlab.motor_design.computed_maps import kept_maps

        force_map = kept_maps().find(plan.geometry, plan.preset)
        if force_map is None:
            kept_maps().check_room()
        return force_map

    def text(self, result: ForceMap) -> str:
        """Return the map's file."""
        return result.text().rstrip("\n")

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add preset, fit and the file to write."""
        parser.add_argument(
            "--preset",
            choices=("preview", "default", "reference"),
            default="default",
            help="preview: a magnetic circuit, at once; default: finite elements; reference: finer "
            "ones, minutes "
            "(default: %(default)s)",
        )
        parser.add_argument(
            "--fit",
            metavar="NAME",
            help="instead, fit the analytic map to the table of that name, for a controller's "
            "model",
        )
        parser.add_argument("--out", metavar="FILE", help="write the map to FILE, .json")

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.motor_design.fem.geometry import geometry

        geometry(changes)  # so that errors name fields as --set does
        return {"preset": options.preset, "geometry": changes}

    def before(self, plan: MapRequest, options: argparse.Namespace) -> str | None:
        """Return the fit if requested; refuse a file that could not be written."""
        from motionlab.motor_design.computed_maps import kept_maps

        if options.fit is not None:
            return _fit(options)
        if kept_maps().find(plan.geometry, plan.preset) is not None:
            print("motionlab: this map was computed before", file=sys.stderr)
        return super().before(plan, options)

    def after(self, result: ForceMap, options: argparse.Namespace) -> None:
        """Write the file of ``--out``, and say where the map is kept and by which name."""
        from motionlab.motor_design.computed_maps import document, kept_maps

        super().after(result, options)
        if shows_progress():
            force_map = document(result)
            where = "ships with the lab" if force_map.shipped else f"kept in {kept_maps().folder}"
            print(
                f"motionlab: {where}; in a motor: --set plant.force_map={force_map.name}",
                file=sys.stderr,
            )


def _fit(options: argparse.Namespace) -> str:
    from motionlab.reports.document_text import document_text
    from motionlab.studies.sharing.sharing import fit

    if options.assignments or options.out is not None:
        wrong = "--set" if options.assignments else "--out"
        raise ConfigError(FieldError(wrong, "does not go with --fit, which reads a stored map"))
    document = fit(options.fit)
    if options.json:
        return json.dumps(document.model_dump(), allow_nan=False)
    return document_text(document)
