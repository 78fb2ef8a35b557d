"""The loops of one axis in the WebAssembly module: linearised, and their margins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.force_gain import force_gains
from motionlab.kernel.layout import (
    LAW_NUMBER,
    LAW_OF_STATE,
    LAW_STATE,
    Command,
    Inputs,
    LawState,
    PlantState,
    State,
    groups,
    parameter_row,
    read_state,
    write_state,
)
from motionlab.kernel.motion import none_ahead, seen
from motionlab.kernel.tick import EncoderSample, command, in_effect, observe_motion
from motionlab.lanes import Lanes, axes_at, compiled, pack, unpack
from motionlab.loop.lane_controller import (
    MEMORY_STATES,
    about,
    linear_numbers,
    read_probes,
    write_probes,
)
from motionlab.loop.lane_loops import UNIT, Loops, close_loops, stability
from motionlab.loop.lane_margins import sample_responses, short_systems, worst_margins
from motionlab.loop.lane_plant import friction_of, plant_about, sliding_force
from motionlab.targets.wasm_laws import estimate_friction

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

LANES = 2
_IDEAL, _V_S = parameter_row("controller.ideal_force"), parameter_row("friction.v_s")
_K_P, _K_D = parameter_row("controller.k_p"), parameter_row("controller.k_d")


@compiled
def _control_once(numbers: Array, state: Array, inputs: Array, p_meas: Array, width: Lanes) -> None:
    """Advance controllers by a period, as `motionlab.kernel.tick.control_once` does."""
    par, s, at = groups(numbers, width), read_state(state, width), axes_at(Inputs, inputs, 0, width)
    measured = unpack(EncoderSample, p_meas, 0, width).p
    motion = observe_motion(par, s, at, measured)
    known = seen(par.controller, par.model_friction, motion, none_ahead(motion))
    law_state = unpack(LawState, state, LAW_STATE, width)
    estimate, law_state = estimate_friction(int(numbers[LAW_NUMBER, 0]), par.law, law_state, known)
    memory, made, signals = command(par, s, motion, estimate, None, None)
    # An ideal force is the command: without currents, nothing of the sharing is compiled.
    none = signals.f_command * 0.0
    made = Command(signals.f_command, made.estimate, made.added, made.K, none, none, none)
    acting = in_effect(par, s.pending, made)
    write_state(State(s.plant, memory, acting, made, s.age, s.failed), state)
    pack(law_state, state[LAW_STATE:LAW_OF_STATE])


def linearise(  # noqa: PLR0913, PLR0917 - parameters, and the arrays of `Loops`
    parameters: Array,
    axis: int,
    tables: Array,
    speeds: Array,
    velocity: Array,
    plant: Array,
    controller: Array,
    matrix: Array,
    fixed: Array,
    frequency: Array,
    response: Complex,
    sizes: Array,
    work: Array,
    upper: Complex,
    numbers: Array,
    state: Array,
    inputs: Array,
    measured: Array,
    sliding: Array,
    forces: Array,
) -> None:
    """Linearise the loop of one axis at velocities, for any gains, as `LoopFamily.of` does."""
    loops = Loops(
        velocity, plant, controller, matrix, fixed, frequency, response, sizes, work, upper
    )
    for row in range(len(parameters)):
        for lane in range(LANES):
            numbers[row, lane] = parameters[row, axis]
    width = unpack(PlantState, state, 0, LANES).p
    friction = friction_of(numbers, 0)
    for v in range(len(speeds)):
        velocity[v] = speeds[v] * numbers[_V_S, 0]
        forces[v // LANES, 0, v % LANES] = sliding_force(friction, velocity[v])
    force_gains(groups(numbers, width), tables, forces, forces)
    states = 0
    for v in range(len(speeds)):
        gain = 1.0 if numbers[_IDEAL, 0] > 0.0 else forces[v // LANES, 0, v % LANES]
        states = plant_about(numbers, velocity[v], gain, False, plant[v], work[0], work[1])
    law_states = 0
    for k in range(3 * len(speeds)):
        corner, v = k // len(speeds), k % len(speeds)
        linear_numbers(numbers, UNIT if corner == 1 else 0.0, UNIT if corner == 2 else 0.0)
        law_states = about(numbers, velocity[v], inputs, sliding)
        system = controller[corner, v]
        for moved in range(law_states + MEMORY_STATES + 1):
            write_probes(moved, numbers, velocity[v], sliding, law_states, state, measured)
            _control_once(numbers, state, inputs, measured, width)
            read_probes(moved, numbers, velocity[v], sliding, law_states, state, system)
    close_loops(loops, states, law_states + MEMORY_STATES)
    short_systems(loops, states, law_states + MEMORY_STATES)
    sample_responses(loops)


def margins(  # noqa: PLR0913, PLR0917 - as `linearise`
    parameters: Array,
    axis: int,
    velocity: Array,
    plant: Array,
    controller: Array,
    matrix: Array,
    fixed: Array,
    frequency: Array,
    response: Complex,
    sizes: Array,
    work: Array,
    upper: Complex,
    gains: Array,
    radii: Array,
    limits: Array,
    worst: Array,
) -> None:
    """Write stability, limits of the gains and worst margins of a loop that is linearised."""
    loops = Loops(
        velocity, plant, controller, matrix, fixed, frequency, response, sizes, work, upper
    )
    gains[0, 0], gains[1, 0] = parameters[_K_P, axis], parameters[_K_D, axis]
    stability(loops, gains[0], gains[1], radii, limits)
    worst_margins(loops, gains[0, 0], gains[1, 0], worst)
