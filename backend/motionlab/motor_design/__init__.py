"""Motor sizing: from requirements to dimensions, and from dimensions to limits."""
