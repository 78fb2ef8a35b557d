"""The calls of a lab in this process, as functions: those of ``import motionlab``."""

from motionlab.scripting.local import Local

_LAB = Local()

run = _LAB.run
sweep = _LAB.sweep
sensitivity = _LAB.sensitivity
tune = _LAB.tune
identify = _LAB.identify
montecarlo = _LAB.montecarlo
design = _LAB.design
study = _LAB.study
kept = _LAB.kept
kept_runs = _LAB.kept_runs
