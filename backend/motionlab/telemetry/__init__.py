"""Recorded channels, their storage and streaming."""
