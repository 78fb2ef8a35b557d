"""Tuning on a machine in few motions, inside what the model and the measurements allow."""
