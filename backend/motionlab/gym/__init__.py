"""Environments for reinforcement learning; importing this registers them with gymnasium."""

try:
    import gymnasium
except ImportError:
    raise ImportError("motionlab.gym needs gymnasium: pip install gymnasium") from None

ID = "motionlab/PlanarMotor-v0"

gymnasium.register(
    ID,
    entry_point="motionlab.gym.environment:PlanarMotorEnv",
    vector_entry_point="motionlab.gym.environment:PlanarMotorVectorEnv",
)
