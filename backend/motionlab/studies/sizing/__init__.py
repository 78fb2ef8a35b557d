"""Motor sizing."""
