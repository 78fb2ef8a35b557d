"""The drive profile of one node: CiA 402 state machine, target current, process data."""

from __future__ import annotations

from motionlab.drive.ethercat import OP, REGISTER_AL_STATUS, REGISTER_SYNC_MANAGER
from motionlab.drive.process_data import (
    CYCLIC_TORQUE,
    ENABLE_OPERATION,
    ENABLE_VOLTAGE,
    FAULT_RESET,
    NO_QUICK_STOP,
    STO_ACTIVE,
    SWITCH_ON,
)
from motionlab.drive.virtual.layout import (
    CONTROL_LAST,
    COUNTED,
    DRIVE_STATE,
    ENCODER_LOST_X,
    ERROR_CODE,
    FAULT_REQUEST,
    FRESH,
    JUMP_X,
    LAST_STEP,
    LIMITED,
    MAILS,
    MAX_CURRENT,
    MAX_TORQUE,
    MODE_DISPLAY,
    POSITION,
    STATUS_WORD,
    STO,
    STUCK_X,
    TARGET,
    TORQUE,
    TORQUE_SLOPE,
    VELOCITY,
    Arrays,
    get8,
    get16,
    part,
    put,
)

(
    NOT_READY,
    SWITCH_ON_DISABLED,
    READY,
    SWITCHED_ON,
    ENABLED,
    QUICK_STOPPING,
    FAULT_REACTION,
    FAULT,
) = range(8)

STATUS = (0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08)
"""Status word of each state, without the bits that do not depend on it."""

VOLTAGE_ON, REMOTE, INTERNAL_LIMIT, FOLLOWS = 0x0010, 0x0200, 0x0800, 0x1000

ENCODER_ERROR = 0x7305
LINK_ERROR = 0x8700
"""Error code 603F of a drive whose process data stopped: sync controller."""

OUTPUT_SYNC, INPUT_SYNC = 2, 3
"""Sync managers of process data."""


@part
def fail(s: Arrays, n: int, code: int) -> None:
    """Take a drive to its fault reaction: no torque from here on."""
    node = s.nodes[n]
    if node[DRIVE_STATE] not in (FAULT_REACTION, FAULT):
        node[DRIVE_STATE] = FAULT_REACTION
        node[ERROR_CODE] = code
        s.clock[MAILS] += 1  # there is an emergency to be sent
    release(s, n)


@part
def release(s: Arrays, n: int) -> None:
    """Command no current."""
    s.nodes[n, TARGET] = 0
    s.nodes[n, LIMITED] = 0
    _command(s, n)


@part
def _command(s: Arrays, n: int) -> None:
    lane, phase = s.wiring[n, 0], s.wiring[n, 1]
    for i in range(lane, s.command.shape[1], 2):
        s.command[phase, i] = 1e-3 * s.nodes[n, TARGET]


@part
def next_state(  # noqa: PLR0911 - one for each row of the table of transitions
    state: int, control: int, reset: bool
) -> int:
    """Return the state that a control word leads to; one transition at a time.

    `reset` tells whether its bit 7 has risen and the cause of a fault is gone.
    """
    if state == FAULT:
        return SWITCH_ON_DISABLED if reset else FAULT
    if not control & ENABLE_VOLTAGE:
        return SWITCH_ON_DISABLED
    if not control & NO_QUICK_STOP:
        return QUICK_STOPPING if state in (ENABLED, QUICK_STOPPING) else SWITCH_ON_DISABLED
    if state == QUICK_STOPPING:
        return state
    if not control & SWITCH_ON:
        return READY
    if state == SWITCH_ON_DISABLED:
        return state
    if state == READY:
        return SWITCHED_ON
    return ENABLED if control & ENABLE_OPERATION else SWITCHED_ON


@part
def read_encoder(s: Arrays, n: int, elapsed: int) -> None:
    """Latch position, velocity over `elapsed` ns, and actual current."""
    node = s.nodes[n]
    lane, phase, encoder = s.wiring[n, 0], s.wiring[n, 1], s.wiring[n, 2]
    current = s.plant[5 + phase, lane]  # i_a, i_b, i_c of PlantState
    node[TORQUE] = round(current * 1e6 / s.ratings[n])
    if encoder < 0 or s.switches[ENCODER_LOST_X + encoder] > 0.0:
        return
    if s.switches[STUCK_X + encoder] > 0.0:
        node[VELOCITY] = 0
        return
    direction, size, offset = s.scales[encoder]
    counts = round(direction * (s.measured[0, encoder] - offset) / size)
    counts += int(s.switches[JUMP_X + encoder])
    if elapsed > 0:
        node[VELOCITY] = round((counts - node[COUNTED]) * 1e9 / elapsed)
    node[COUNTED] = counts
    node[POSITION] = counts


@part
def target_current(s: Arrays, n: int, torque: int) -> None:
    """Command the current of target torque 6071: not negative, within 6072 and 6073."""
    node = s.nodes[n]
    most = min(s.objects[n, MAX_TORQUE], s.objects[n, MAX_CURRENT])
    within = min(max(torque, 0), most)
    node[LIMITED] = int(within != torque)
    node[TARGET] = within * s.ratings[n] // 1000
    _command(s, n)


@part
def ramp_down(s: Arrays, n: int, elapsed: int) -> bool:
    """Take the current towards zero at object 6087 for `elapsed` ns; tell whether any is left."""
    node = s.nodes[n]
    fall = s.objects[n, TORQUE_SLOPE] * s.ratings[n] * max(elapsed, 1)
    node[TARGET] = max(node[TARGET] - fall // 1_000_000_000_000, 0)
    node[LIMITED] = 0
    _command(s, n)
    return node[TARGET] > 0


@part
def step_drive(s: Arrays, n: int, time: int, elapsed: int, obey: bool) -> None:
    """Latch inputs, step the state machine, apply outputs, and write the inputs.

    `elapsed`, ns, keeps the velocity where it is 0. Unless outputs are to be obeyed, only reactions
    go on.
    """
    node = s.nodes[n]
    before = node[DRIVE_STATE]
    read_encoder(s, n, elapsed)
    encoder = s.wiring[n, 2]
    lost = encoder >= 0 and s.switches[ENCODER_LOST_X + encoder] > 0.0
    if node[FAULT_REQUEST] or lost:
        fail(s, n, node[FAULT_REQUEST] if node[FAULT_REQUEST] else ENCODER_ERROR)
        node[FAULT_REQUEST] = 0

    memory = s.memory[n]
    outputs = get16(memory, REGISTER_SYNC_MANAGER + 8 * OUTPUT_SYNC)
    operational = (memory[REGISTER_AL_STATUS] & 0x0F) == OP
    control = torque = mode = 0
    if obey:
        control = get16(memory, outputs)
        torque = get16(memory, outputs + 2)
        torque -= 0x1_0000 if torque >= 0x8000 else 0
        mode = get8(memory, outputs + 4)
        if mode == CYCLIC_TORQUE:  # 0 changes nothing; others are not supported, nor displayed
            node[MODE_DISPLAY] = mode
    follows = node[MODE_DISPLAY] == CYCLIC_TORQUE and mode in (0, CYCLIC_TORQUE)

    state = node[DRIVE_STATE]
    if state == FAULT_REACTION:
        state = FAULT if before == FAULT_REACTION else FAULT_REACTION
    elif obey:
        rising = bool(control & ~node[CONTROL_LAST] & FAULT_RESET)
        node[CONTROL_LAST] = control
        state = next_state(state, control, rising and not lost)
        if before == FAULT and state != FAULT:
            node[ERROR_CODE] = 0
            s.clock[MAILS] += 1
    elif state not in (SWITCH_ON_DISABLED, FAULT):
        state = SWITCH_ON_DISABLED
    safe_off = s.switches[STO] > 0.0
    if safe_off and state not in (FAULT_REACTION, FAULT):
        state = SWITCH_ON_DISABLED

    if state == QUICK_STOPPING:
        if not ramp_down(s, n, elapsed):
            state = SWITCH_ON_DISABLED
    elif state == ENABLED and follows:
        target_current(s, n, torque)
    else:
        release(s, n)
    node[DRIVE_STATE] = state
    node[LAST_STEP] = time
    node[FRESH] = 0
    write_inputs(s, n, operational, safe_off)


@part
def write_inputs(s: Arrays, n: int, operational: bool, safe_off: bool) -> None:
    """Write the inputs, TxPDO 1A00, into the process memory."""
    node = s.nodes[n]
    state = node[DRIVE_STATE]
    status = STATUS[state] | VOLTAGE_ON
    if operational:
        status |= REMOTE
    if safe_off:
        status |= STO_ACTIVE
    if node[LIMITED]:
        status |= INTERNAL_LIMIT
    if state == ENABLED and node[MODE_DISPLAY] == CYCLIC_TORQUE:
        status |= FOLLOWS
    node[STATUS_WORD] = status
    memory = s.memory[n]
    at = get16(memory, REGISTER_SYNC_MANAGER + 8 * INPUT_SYNC)
    if at < 0x1000 or at + 16 > memory.shape[0]:
        return  # not set up
    put(memory, at, status, 2)
    put(memory, at + 2, node[POSITION], 4)
    put(memory, at + 6, node[VELOCITY], 4)
    put(memory, at + 10, node[TORQUE], 2)
    put(memory, at + 12, node[MODE_DISPLAY], 1)
    put(memory, at + 13, 0, 1)
    put(memory, at + 14, node[ERROR_CODE], 2)
