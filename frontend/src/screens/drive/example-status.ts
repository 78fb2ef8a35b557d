/** A drive link as tests need it: operational, without torque, held by no one. */

import type { DriveStatus, FaultNow, OneDrive } from '../../app/api/types';

const PLACES = ['x a', 'x b', 'x c', 'y a', 'y b', 'y c'];

export function exampleDrive(change: Partial<OneDrive> = {}): OneDrive {
  return {
    axis: 'x',
    phase: 'a',
    state: 'ready to switch on',
    status_word: 0x1231,
    error: 0,
    error_name: '',
    sto: false,
    current: 0,
    current_max: 10,
    rated_current: 10,
    vendor: 0xe0000001,
    product: 0x5001,
    // eslint-disable-next-line id-denylist -- a name of the server's document
    found: null,
    answers: null,
    ...change,
  };
}

export function exampleFault(change: Partial<FaultNow> = {}): FaultNow {
  return {
    code: 0x8611,
    error: 0,
    name: 'following error beyond its window',
    subject: 'axis',
    place: 2,
    value: 512.34,
    limit: 500,
    unit: 'µm',
    remedy: 'Look for a mechanical obstacle.',
    ...change,
  };
}

export function exampleStatus(
  change: Partial<DriveStatus> = {},
  loop: Partial<DriveStatus['loop']> = {},
): DriveStatus {
  const limits = {
    encoder: 1,
    resolution: 50e-9,
    direction: 1 as const,
    offset: 0,
    position_min: -0.0845,
    position_max: 0.0845,
    velocity_max: 0.5,
    deceleration: 3,
    following_error: 500e-6,
    following_error_time: 0.01,
    current_max: 10,
  };
  return {
    title: 'Virtual drive',
    virtual: true,
    state: 'ready',
    problem: '',
    step: 'operational',
    fault: null,
    faults: [],
    holder: null,
    held_since: null,
    asking: null,
    stopped: null,
    known: true,
    age: 0.0004,
    other_drives: '',
    bus: {
      carrier: 'udp',
      place: '127.0.0.1:34980',
      slow: 1,
      distributed_clocks: true,
      watchdog: 0.02,
      loss: 0.01,
    },
    drives: PLACES.map((place) => exampleDrive({ axis: place.slice(0, 1), phase: place.slice(2) })),
    axes: ['x', 'y'].map((axis) => ({
      axis,
      position: 0.0123,
      velocity: 0,
      following_error: 0,
      limits,
    })),
    loop: {
      cycles: 500_000,
      late: 80,
      late_run: 7,
      missed: 12,
      working_counter: 6,
      al_status: 8,
      phase_error: -1.3e-6,
      phase_locked: true,
      round_trip: 39e-6,
      wake_late: 61e-6,
      control_time: 3.8e-6,
      period: 500e-6,
      age: 0.0004,
      priority_wanted: 80,
      priority: 80,
      memory_locked: true,
      recent: {
        seconds: 60,
        cycles: 120_000,
        late: 61,
        missed: 4,
        missed_each_second: [0, 1, 0, 3],
        p50: 39e-6,
        p99: 81e-6,
        p999: null,
        bin_width: 4e-6,
        round_trips: [0, 119_990, 0, 10],
      },
      ...loop,
    },
    ...change,
  };
}
