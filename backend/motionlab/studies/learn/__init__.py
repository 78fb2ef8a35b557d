"""Learning from lap to lap of a motion that repeats."""
