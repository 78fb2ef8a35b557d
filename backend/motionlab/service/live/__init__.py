"""Live sessions: the clock that advances them, what changes them, and their streams."""
