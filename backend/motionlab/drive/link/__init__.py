"""The master: brings drives up, runs the loop in its own process, hands over its samples."""
