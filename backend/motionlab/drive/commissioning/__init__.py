"""Commissioning: what is checked before a machine moves, step after step, and what was found."""
