"""Force sharing over a pole pitch by each function."""
