"""User data on disk."""
