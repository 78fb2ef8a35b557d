"""Super-twisting sliding mode on one axis, in python-control: `nlsys`, a period at a time."""

import time

import control
import numpy as np

M, S0, S1, S2, F_C, F_S, V_S = 5.9, 118913.2532, 1162.3, 10.3128, 0.2399, 3.5908, 0.0436
K_P, K_D, LIMIT, T = 2.003e5, 1530.0, 40.0, 5e-4
SLOPE, ROOT, INTEGRAL, LAYER = 60.0, 10.0, 300.0, 2e-3


def reference(t):
    s = min(t, 1.0)
    return 0.02 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def motor(_t, state, force, _params):
    _, v, z = state
    g = (F_C + (F_S - F_C) * np.exp(-((v / V_S) ** 2))) / S0
    z_rate = v - abs(v) / g * z
    friction = S0 * z + S1 * z_rate + S2 * v
    return [v, (force[0] - friction) / M, z_rate]


def law(e, e_rate, w):
    s = e_rate + SLOPE * e
    side = np.clip(s / LAYER, -1.0, 1.0)
    w = np.clip(w + T * INTEGRAL * side, -10.0, 10.0)
    return ROOT * np.sqrt(abs(s)) * side + w, w


def experiment():
    plant = control.nlsys(motor, None, inputs=1, outputs=3, states=3)
    state, w, e_last, peak = np.zeros(3), 0.0, 0.0, 0.0
    for k in range(4000):
        e = reference(k * T) - state[0]
        e_rate = (e - e_last) / T if k else 0.0
        added, w = law(e, e_rate, w)
        force = np.clip(np.clip(K_P * e + K_D * e_rate, -LIMIT, LIMIT) + added, -LIMIT, LIMIT)
        answer = control.input_output_response(
            plant, [0.0, T], [force, force], state, solve_ivp_kwargs={"rtol": 1e-6, "atol": 1e-12}
        )
        state, e_last, peak = answer.states[:, -1], e, max(peak, abs(e))
    return peak


start = time.perf_counter()
error = experiment()
print(f"{1e6 * error:.3f} {time.perf_counter() - start:.3f}")
