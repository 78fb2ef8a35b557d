"""A motion lab for planar switched reluctance motors."""

__version__ = "0.1.0"
