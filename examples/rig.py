"""A machine that the lab does not know writes rig.csv; docs/rig.md goes on from there.

A carriage of 4.2 kg with 1.1 kg on a spring, its encoder on the carriage, friction that grows with
a clamp, and a drive with a PD controller of 2 kHz. It shares no code with the lab. First the
carriage moves to and fro, slowly, then faster, while the clamp opens and closes; then it slides
while noise shakes the set-point. The columns are those that such a drive logs. Options are the
gains of its controller and the file to write.

    .venv/bin/python examples/rig.py
    .venv/bin/python examples/rig.py --k-p 180000 --k-d 2200 --out rig-again.csv
"""

import argparse
import csv
import math

import numpy as np
from scipy import linalg, optimize

RATE, SUBSTEPS = 2000, 10
CARRIAGE, LOAD = 4.2, 1.1  # kg
MODE, DAMPING = 140.0, 0.02  # Hz and damping ratio of the mode
F_C, MU, F_S, V_S = 2.5, 0.12, 1.3, 0.006  # N, 1, times the level, m/s
SIGMA_0, SIGMA_1, SIGMA_2 = 8e5, 400.0, 9.0  # N/m, N s/m, N s/m
LAG = 0.15e-3  # s, of the force
COUNT, FORCE_STEP = 50e-9, 0.005  # m, N
MOVES, SLIDES, SLIDE = 24.0, 4, 10.0  # s, number, s
VELOCITY, SHAKEN = 0.015, 1.5  # m/s of a slide, m/s^2 RMS of the noise

REDUCED = CARRIAGE * LOAD / (CARRIAGE + LOAD)
SPRING = (2.0 * math.pi * MODE) ** 2 * REDUCED
DAMPER = 2.0 * DAMPING * 2.0 * math.pi * MODE * REDUCED


def setpoint() -> np.ndarray:
    """Return the set-point, m, every half millisecond."""
    time = np.arange(round(MOVES * RATE)) / RATE
    slow = 0.02 * np.sin(2.0 * np.pi * 0.25 * time) * (time < 16.0)
    fast = 0.01 * np.sin(2.0 * np.pi * 1.0 * time) * (time >= 16.0)
    samples = round(SLIDE * RATE)
    ends = round(0.25 * RATE)
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(ends) / ends)
    speed = VELOCITY * np.concatenate([rise, np.ones(samples - 2 * ends), rise[::-1]])
    f = np.fft.rfftfreq(samples, 1.0 / RATE)
    shape = np.where((f >= 1.0) & (f <= 600.0), 1.0 / np.maximum(f, 20.0) ** 1.5, 0.0)
    rng, parts = np.random.default_rng(7), [slow + fast]
    for number in range(SLIDES):
        phases = np.exp(2j * np.pi * rng.random(len(f)))
        noise = np.fft.irfft(shape * phases)
        noise *= SHAKEN / np.fft.irfft(shape * phases * (2.0 * np.pi * f) ** 2).std()
        way = np.cumsum(speed) / RATE * (1.0 if number % 2 == 0 else -1.0)
        start = 0.0 if number % 2 == 0 else VELOCITY * (samples - ends) / RATE
        parts.append(start + way + noise * speed / VELOCITY)
    return np.concatenate(parts)


def moved(
    reference: np.ndarray, k_p: float, k_d: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, m, force and clamping force, N, of the machine under its controller."""
    time = np.arange(len(reference)) / RATE
    clamp = 20.0 + 12.0 * np.sin(2.0 * np.pi * time / 7.0) * (time < MOVES)
    rng = np.random.default_rng(3)
    noise = 0.01 * rng.standard_normal(len(time))
    x = v = x_load = v_load = z = acting = earlier = 0.0
    dt, kept = 1.0 / (RATE * SUBSTEPS), math.exp(-1.0 / (RATE * SUBSTEPS * LAG))
    position, force = np.empty(len(time)), np.empty(len(time))
    for k, (target, normal) in enumerate(zip(reference.tolist(), clamp.tolist(), strict=True)):
        measured = round(x / COUNT) * COUNT
        error = target - measured
        command = k_p * error + k_d * (error - earlier) * RATE
        earlier = error
        position[k], force[k] = measured, command
        level = F_C + MU * normal
        for _ in range(SUBSTEPS):
            g = level * (1.0 + (F_S - 1.0) * math.exp(-((v / V_S) ** 2)))
            # The bristle by its exact step, since it is faster than dt.
            rate = SIGMA_0 * abs(v) / g
            old, aim = z, math.copysign(g / SIGMA_0, v)
            z = aim + (z - aim) * math.exp(-rate * dt)
            friction = SIGMA_0 * z + SIGMA_1 * (z - old) / dt + SIGMA_2 * v
            spring = SPRING * (x - x_load) + DAMPER * (v - v_load)
            # Leapfrog: velocities are half a step later than places and forces.
            v += dt * (acting - friction - spring) / CARRIAGE
            v_load += dt * spring / LOAD
            x += dt * v
            x_load += dt * v_load
            acting = command + (acting - command) * kept
    return position, np.round((force + noise) / FORCE_STEP) * FORCE_STEP, clamp


def plant(f: np.ndarray, viscous: float) -> np.ndarray:
    """Return the response of position to a held force command, m/N, sliding at a velocity."""
    A = np.zeros((5, 5))
    A[0, 1] = A[2, 3] = 1.0
    A[1] = np.array([-SPRING, -DAMPER - viscous, SPRING, DAMPER, 1.0]) / CARRIAGE
    A[3, :4] = np.array([SPRING, DAMPER, -SPRING, -DAMPER]) / LOAD
    A[4, 4] = -1.0 / LAG
    whole = np.zeros((6, 6))
    whole[:5, :5], whole[4, 5] = A, 1.0 / LAG
    step = linalg.expm(whole / RATE)
    Ad, Bd = step[:5, :5], step[:5, 5]
    turns = np.exp(2j * np.pi * f / RATE)
    return np.array([np.linalg.solve(turn * np.eye(5) - Ad, Bd)[0] for turn in turns])


def margins(k_p: float, k_d: float) -> None:
    """Print the margins of the linear loop: what a measurement of the machine should tell."""

    def loop(f: np.ndarray) -> np.ndarray:
        late = np.exp(-2j * np.pi * f / RATE)
        return (k_p + k_d * (1.0 - late) * RATE) * plant(f, SIGMA_2)

    f = np.linspace(1.0, 700.0, 20000)
    L = loop(f)
    size, phase = np.abs(L), np.unwrap(np.angle(L))
    phase -= 2.0 * np.pi * np.round((phase[0] + np.pi) / (2.0 * np.pi))
    for k in np.flatnonzero(np.diff(np.sign(size - 1.0))):
        at = optimize.brentq(lambda one: abs(loop(np.array([one]))[0]) - 1.0, f[k], f[k + 1])
        print(f"crossover {at:.1f} Hz, phase margin {math.degrees(phase[k]) % 360 - 180:.1f} deg")
    for k in np.flatnonzero(np.diff(np.floor((phase - np.pi) / (2.0 * np.pi)))):
        print(f"phase of -180 deg at {f[k]:.1f} Hz, gain margin {-20 * math.log10(size[k]):.1f} dB")


def main() -> None:
    """Write what the machine logs, and print what is true of it."""
    parser = argparse.ArgumentParser(description="A machine that the lab does not know.")
    parser.add_argument("--k-p", type=float, default=90e3, help="N/m")
    parser.add_argument("--k-d", type=float, default=1100.0, help="N s/m")
    parser.add_argument("--out", default="rig.csv", help="the file to write")
    options = parser.parse_args()
    reference = setpoint()
    position, force, clamp = moved(reference, options.k_p, options.k_d)
    with open(options.out, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["t [s]", "setpoint [mm]", "position [mm]", "force [N]", "clamp [N]"])
        rows = zip(reference, position, force, clamp, strict=True)
        for k, (r, p, u, n) in enumerate(rows):
            writer.writerow(
                [f"{k / RATE:.4f}", f"{1e3 * r:.6f}", f"{1e3 * p:.5f}", f"{u:.3f}", f"{n:.2f}"]
            )
    print(f"{options.out}: {len(reference)} samples, |force| up to {np.abs(force).max():.0f} N")
    print(f"mass {CARRIAGE + LOAD:g} kg, F_c {F_C:g} N, mu {MU:g}, mode {MODE:g} Hz")
    margins(options.k_p, options.k_d)


if __name__ == "__main__":
    main()
