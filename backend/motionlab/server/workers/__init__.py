"""Processes that compute for the server, so that its own event loop only ever waits."""
