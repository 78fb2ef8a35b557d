"""The loop of one axis over frequency, linearised and measured."""
