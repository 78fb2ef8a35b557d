"""Super-twisting sliding mode on one axis, in motulator: a subsystem, a model, a control system."""

import time
from types import SimpleNamespace

import numpy as np
from motulator.common.model._simulation import Model, Simulation, Subsystem

M, S0, S1, S2, F_C, F_S, V_S = 5.9, 118913.2532, 1162.3, 10.3128, 0.2399, 3.5908, 0.0436
K_P, K_D, LIMIT, T = 2.003e5, 1530.0, 40.0, 5e-4
SLOPE, ROOT, INTEGRAL, LAYER = 60.0, 10.0, 300.0, 2e-3


def reference(t):
    s = min(t, 1.0)
    return 0.02 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


class Mover(Subsystem):
    def __init__(self):
        super().__init__()
        self.state = SimpleNamespace(p=0.0, v=0.0, z=0.0)
        self.sol_states = SimpleNamespace(p=[], v=[], z=[])
        self.inp = SimpleNamespace(q_cs=0.0)
        self.sol_q_cs = []

    def rhs(self):
        v, z = self.state.v, self.state.z
        g = (F_C + (F_S - F_C) * np.exp(-((v / V_S) ** 2))) / S0
        z_rate = v - abs(v) / g * z
        friction = S0 * z + S1 * z_rate + S2 * v
        return [v, (self.inp.q_cs - friction) / M, z_rate]


class Axis(Model):
    def __init__(self):
        super().__init__(pwm=lambda T_s, force: ([T_s], [force]), delay=0)
        self.delay = lambda force: force
        self.converter = Mover()
        self.subsystems = [self.converter]

    def interconnect(self, t):
        pass

    def post_process(self):
        self.post_process_states()


class SuperTwisting:
    def __init__(self):
        self.w = self.e_last = self.k = 0.0
        self.errors = []

    def __call__(self, mdl):
        e = reference(mdl.t0) - (mdl.converter.sol_states.p or [0.0])[-1]
        e_rate = (e - self.e_last) / T if self.errors else 0.0
        s = e_rate + SLOPE * e
        side = np.clip(s / LAYER, -1.0, 1.0)
        self.w = np.clip(self.w + T * INTEGRAL * side, -10.0, 10.0)
        added = ROOT * np.sqrt(abs(s)) * side + self.w
        self.e_last = e
        self.errors.append(e)
        pd = np.clip(K_P * e + K_D * e_rate, -LIMIT, LIMIT)
        return T, np.clip(pd + added, -LIMIT, LIMIT)

    def post_process(self):
        pass


start = time.perf_counter()
ctrl = SuperTwisting()
Simulation(Axis(), ctrl).simulate(t_stop=2.0 - 1.5 * T)
error = np.abs(ctrl.errors).max()
print(f"{1e6 * error:.3f} {time.perf_counter() - start:.3f}")
