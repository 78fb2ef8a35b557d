"""Files of other programs, both ways: measurements, paths, runs."""
