"""Exit codes of the command line."""

DONE, FAILED, BAD_INPUT = 0, 1, 2
INTERRUPTED = 130
"""128 and the number of SIGINT, as shells have it."""
