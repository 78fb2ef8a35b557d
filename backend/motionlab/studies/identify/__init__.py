"""Friction identification as an experiment: what a real machine could measure, and fits to it."""
