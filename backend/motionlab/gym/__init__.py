"""Environments for reinforcement learning; importing this registers them with gymnasium."""

from motionlab.errors import naming_extras

with naming_extras("motionlab.gym"):
    import gymnasium

ID = "motionlab/PlanarMotor-v0"

gymnasium.register(
    ID,
    entry_point="motionlab.gym.environment:PlanarMotorEnv",
    vector_entry_point="motionlab.gym.environment:PlanarMotorVectorEnv",
)
