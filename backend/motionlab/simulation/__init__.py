"""Running a scenario: the kernel, its inputs, and what comes of it."""
