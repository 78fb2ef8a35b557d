"""One module a version of the index."""
