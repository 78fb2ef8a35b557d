"""Frozen config models of a scenario, and the loader."""
