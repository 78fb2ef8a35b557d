"""Tuning: gain search by the simplex, cost maps, and the stability boundary."""
