"""Evaluation of a run: metrics, comparison, result document."""
