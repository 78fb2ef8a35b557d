"""Measurements of real machines as runs."""
