"""The lab from Python: what ``import motionlab`` offers, here or on a server."""
