"""Controllers and motors to linearise, drawn by hypothesis."""

from __future__ import annotations

from hypothesis import strategies as st

_A, _PLANT = "variants.A.controller", "plant.x"

CHANGES = st.fixed_dictionaries(
    {
        f"{_A}.compensation.law": st.sampled_from(
            ["off", "lugre-observer", "residual-k", "canudas-de-wit", "reversed-k"]
        ),
        f"{_A}.compensation.velocity": st.sampled_from(["reference", "measured"]),
        f"{_A}.sharing.law": st.sampled_from(["least-norm", "least-normal-force", "sine", "cubic"]),
        f"{_A}.disturbance_observer.enabled": st.booleans(),
        f"{_A}.delay": st.integers(0, 1),
        f"{_A}.x.notch.gain": st.sampled_from([1.0, 0.1]),
        f"{_A}.x.k_p": st.floats(1e4, 3e6),
        f"{_A}.x.k_d": st.floats(300.0, 2e4),
        f"{_PLANT}.mass": st.floats(5.0, 7.0),
        f"{_PLANT}.friction.F_c": st.floats(0.1, 3.0),
        f"{_PLANT}.friction.sigma_1": st.floats(600.0, 1500.0),
        f"{_PLANT}.resonance.coupling": st.sampled_from([0.0, -1.0, 0.5]),
        f"{_PLANT}.amplifiers.gain": st.sampled_from([(1.0, 1.0, 1.0), (1.02, 0.97, 1.0)]),
    }
)
