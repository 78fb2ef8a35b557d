"""Identification of friction from a recorded run: a drive's, or an imported measurement."""
