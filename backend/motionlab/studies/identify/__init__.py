"""Friction identification as an experiment: measurements of a real machine, and fits to them."""
