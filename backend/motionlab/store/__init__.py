"""What users save on disk."""
