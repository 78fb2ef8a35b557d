"""The controller's computations in one period: position control, friction compensation, sharing."""
