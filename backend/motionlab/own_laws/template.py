"""The files that ``motionlab new-law`` writes, to be changed: a law, and an effect of the plant."""

from __future__ import annotations

import re
from pathlib import Path

from motionlab.declarations import NAME_MAX
from motionlab.errors import ConfigError, FieldError

_TEXT = '''\
"""{title}: the Coulomb friction of the model, with the sign of the reference's velocity."""
from typing import NamedTuple
from motionlab.lanes import Lanes, compiled, select
from motionlab.laws.law import Estimate, Law, Parameter
SHARE = Parameter("{name}_share", "Share of F_c compensated", unit="1", default=1, ge=0, le=2)
class Parameters(NamedTuple):  # of a lane: an axis of a controller
    {name}_share: Lanes  # 1
@compiled
def {name}(par, state, seen):  # once in a control period; `seen` is motionlab.laws.law.Seen
    """Compensate ``share F_c sgn(v_ref)``."""
    force = par.{name}_share * seen.friction.F_c  # N
    force = select(seen.v_ref > 0.0, force, select(seen.v_ref < 0.0, -force, 0.0))  # for `if`
    return Estimate(force, z=0.0, K=0.0), state  # what is added to PD, and the next state
LAW = Law(name="{law}", description="F_c with the sign of the reference's velocity", step={name},
          Parameters=Parameters, parameters=(SHARE,))
'''
_EFFECT = '''\
"""{title}: a cable that pulls the mover towards mid-stroke."""
from typing import NamedTuple
from motionlab.effects.effect import Effect, Parameter, Resistance
from motionlab.lanes import Lanes, compiled
STIFFNESS = Parameter("stiffness", "Stiffness", unit="N/m", default=10, ge=0, le=1e4)
class Parameters(NamedTuple):  # of a lane: an axis of a motor
    stiffness: Lanes  # N/m
@compiled
def {name}(par, state, seen):  # once in 0.1 ms; `seen` is motionlab.effects.effect.MidStep
    """Pull with ``k p``."""
    force = par.stiffness * seen.position  # N, subtracted from the thrust as friction is
    return Resistance(force, damping=0.0), state  # with its derivative by velocity; next state
EFFECT = Effect(name="{law}", description="A cable as a spring towards mid-stroke", step={name},
                Parameters=Parameters, parameters=(STIFFNESS,), friction=False)
'''


def template(name: str, *, effect: bool = False) -> str:
    """Return the text of a law, or an effect, of this name.

    Raises
    ------
    ConfigError
        If a law cannot have the name.
    """
    if not re.fullmatch(r"[a-z][a-z0-9-]*", name) or len(name) > NAME_MAX - len("_share"):
        allowed = f"small letters, digits and -, a letter first, {NAME_MAX - 6} characters at most"
        raise ConfigError(FieldError("NAME", "is no name for a law", name, allowed))
    return (_EFFECT if effect else _TEXT).format(
        law=name, name=name.replace("-", "_"), title=name.replace("-", " ").capitalize()
    )


def write_template(name: str, folder: Path, *, effect: bool = False) -> Path:
    """Write the file of a new law, or effect, into a folder, and return its path.

    Raises
    ------
    ConfigError
        If a law cannot have the name, or the file is there already.
    """
    text, path = template(name, effect=effect), folder / f"{name.replace('-', '_')}.py"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise ConfigError(
            FieldError("NAME", "has a file already, which is not overwritten", str(path))
        ) from None
    return path
