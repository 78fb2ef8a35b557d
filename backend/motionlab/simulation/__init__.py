"""Simulation of a scenario: preparation, inputs, runs, batches and results."""
