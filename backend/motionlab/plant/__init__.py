"""The motor: friction, force map, current loops, encoder, mechanics."""
