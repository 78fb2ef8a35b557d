"""Loop shaping on a measured frequency response."""
