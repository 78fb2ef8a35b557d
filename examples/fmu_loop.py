"""Close a loop around the exported motor: ``motionlab export-plant circle --out plant.fmu`` first.

Run with ``.venv/bin/python examples/fmu_loop.py plant.fmu``; needs the extra ``fmu``.
"""

import math
import sys

import fmpy
from fmpy.fmi3 import FMU3Slave

PERIOD, SECONDS = 0.5e-3, 2.0
K_P, K_D, F_MAX = 200300.0, 1530.0, 30.0  # N/m, N s/m, N

description = fmpy.read_model_description(sys.argv[1])
variables = {variable.name: variable for variable in description.modelVariables}
tau, F_pk, I_pk, I_knee = (
    float(variables[f"x.force_map.{name}"].start) for name in ("tau", "F_pk", "I_pk", "I_knee")
)
B = (I_pk / I_knee) ** 2


def currents(force: float, position: float) -> list[float]:
    """Share a force, N, among three phases by least norm; A."""
    turns = position / tau
    sense = math.copysign(1.0, force)
    pulling = [max(sense * math.sin(2 * math.pi * (turns - k / 3)), 0.0) for k in range(3)]
    scale = abs(force) / (F_pk * sum(s * s for s in pulling))
    parts = [min(scale * s, 1.0) for s in pulling]
    return [I_pk * math.sqrt(y / (1.0 + B * (1.0 - y))) for y in parts]


unit = FMU3Slave(
    guid=description.guid,
    unzipDirectory=fmpy.extract(sys.argv[1]),
    modelIdentifier=description.coSimulation.modelIdentifier,
    instanceName="plant",
)
unit.instantiate()
unit.enterInitializationMode()
unit.exitInitializationMode()
measured = [variables["x.position_measured"].valueReference]
commands = [variables[f"x.current_command_{phase}"].valueReference for phase in "abc"]

(start,) = unit.getFloat64(measured)
last = worst = 0.0
for k in range(round(SECONDS / PERIOD)):
    (position,) = unit.getFloat64(measured)
    reference = start + 0.5e-3 * (1.0 - math.cos(2 * math.pi * k * PERIOD))
    error = reference - position
    force = K_P * error + K_D * (error - last) / PERIOD
    last, worst = error, max(worst, abs(error))
    force = max(-F_MAX, min(F_MAX, force))
    unit.setFloat64(commands, currents(force, position))
    unit.doStep(k * PERIOD, PERIOD)
unit.terminate()
unit.freeInstance()
print(f"largest following error {worst * 1e6:.1f} um")
