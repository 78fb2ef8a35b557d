"""A motion lab for planar switched reluctance motors."""

import os

__version__ = "0.1.0"

# Before numpy is loaded: matrices are small here, and simulations fill the cores with threads of
# their own, between which those of OpenBLAS only spin.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
