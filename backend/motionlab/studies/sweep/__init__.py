"""Sweeps: a scenario over a grid or a list of values of any of its fields."""
