"""Bending of the moving platforms under the movers' normal forces."""
