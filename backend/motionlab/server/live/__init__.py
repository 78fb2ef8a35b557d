"""Live sessions: their clock, changes and streams."""
