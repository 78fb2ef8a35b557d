"""How every metric of a scenario changes with each of its numbers."""
