"""Configs: frozen models of everything a scenario holds, and the loader."""
