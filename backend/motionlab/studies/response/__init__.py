"""Measured frequency responses of the plant, with intervals."""
