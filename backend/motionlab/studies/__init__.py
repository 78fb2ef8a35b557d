"""Computations over many simulations, each in a folder of its own."""
