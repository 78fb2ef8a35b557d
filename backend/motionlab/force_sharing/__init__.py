"""Sharing a force command among three phases."""
