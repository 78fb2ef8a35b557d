"""Super-twisting sliding mode on one axis, in plain numba: everything in one compiled loop."""

import time

import numba
import numpy as np

M, S0, S1, S2, F_C, F_S, V_S = 5.9, 118913.2532, 1162.3, 10.3128, 0.2399, 3.5908, 0.0436
K_P, K_D, LIMIT, T = 2.003e5, 1530.0, 40.0, 5e-4
SLOPE, ROOT, INTEGRAL, LAYER = 60.0, 10.0, 300.0, 2e-3
STEPS = 100  # of the motor in a period: the bristle is stiff for an explicit step


@numba.njit
def experiment():
    p = v = z = w = e_last = peak = 0.0
    h = T / STEPS
    for k in range(4000):
        s = min(k * T, 1.0)
        e = 0.02 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2) - p
        e_rate = (e - e_last) / T if k else 0.0
        line = e_rate + SLOPE * e
        side = min(max(line / LAYER, -1.0), 1.0)
        w = min(max(w + T * INTEGRAL * side, -10.0), 10.0)
        force = min(max(K_P * e + K_D * e_rate, -LIMIT), LIMIT)
        force = min(max(force + ROOT * np.sqrt(abs(line)) * side + w, -LIMIT), LIMIT)
        for _ in range(STEPS):
            g = (F_C + (F_S - F_C) * np.exp(-((v / V_S) ** 2))) / S0
            z_rate = v - abs(v) / g * z
            v += h * (force - S0 * z - S1 * z_rate - S2 * v) / M
            p += h * v
            z += h * z_rate
        e_last, peak = e, max(peak, abs(e))
    return peak


experiment()  # compiles
start = time.perf_counter()
error = experiment()
print(f"{1e6 * error:.3f} {time.perf_counter() - start:.3f}")
