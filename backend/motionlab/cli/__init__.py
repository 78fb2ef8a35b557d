"""The command line, a module for each command."""

from motionlab.cli.main import main

__all__ = ["main"]
