"""Tuning: gains found by the simplex, gain landscapes, and the edge of stability."""
