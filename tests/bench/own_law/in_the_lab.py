"""The same in the lab: the law is a file, docs/own-law.md, and this the experiment."""

import time

import motionlab

LINE = {"kind": "line", "start": {"x": 0.0, "y": 0.0}, "end": {"x": 0.02, "y": 0.0}}
IDEAL = {
    "trajectory": LINE | {"edge_time": 1.0, "dwell": 0.0},
    "plant.force": "ideal",
    "plant.x.encoder.resolution": 0.0,
    "variants.B.controller.compensation.law": "super-twisting",
}

motionlab.run("circle", IDEAL)  # compiles, or loads what is compiled
start = time.perf_counter()
run = motionlab.run("circle", IDEAL)
seconds = time.perf_counter() - start
error = run.metrics["B"]["x"]["max_abs_following_error"]
print(f"{1e6 * error:.3f} {seconds:.3f}")
