"""Runs: kept records of simulations, live sessions and measurements."""
