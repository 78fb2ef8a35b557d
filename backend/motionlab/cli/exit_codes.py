"""What the process returns."""

DONE, FAILED, BAD_INPUT = 0, 1, 2
