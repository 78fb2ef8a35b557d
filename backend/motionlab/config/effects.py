"""Effects of an axis: the config of each, made of the parameters that it declares."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import Field, create_model

from motionlab.config.quantity import Config, declared_field
from motionlab.effects import EFFECTS, Effect
from motionlab.plant.friction import LuGre


class AnyEffectConfig(Config):
    """What the config of every effect has."""

    effect: str

    def lane(self, friction: LuGre) -> tuple[str, Any]:
        """Return the name of the effect and its `Parameters`, as plain numbers."""
        effect = EFFECTS[self.effect]
        values = {each.name: getattr(self, each.name) for each in effect.parameters}
        return effect.name, effect.lane_parameters(values, friction)


def _config_of(effect: Effect) -> Any:
    words = effect.name.replace("_", "-").split("-")
    fields: dict[str, Any] = {each.name: declared_field(each, None) for each in effect.parameters}
    name: Any = (Literal[effect.name], Field(title="effect", description=effect.description))
    title = f"{''.join(word.capitalize() for word in words)}EffectConfig"
    model = create_model(
        title,
        __base__=AnyEffectConfig,
        __doc__=f"{effect.description}.",
        __module__=__name__,
        effect=name,
        **fields,
    )
    globals()[title] = model  # where workers find the class of what is sent to them
    return model


if TYPE_CHECKING:
    EffectConfig = AnyEffectConfig
else:
    EffectConfig = Annotated[
        Union[tuple(_config_of(each) for each in EFFECTS.values())],  # noqa: UP007 - a variable one
        Field(discriminator="effect"),
    ]
"""One effect; which one, ``effect`` says."""
