"""Bending of moving platforms."""
