"""Math channels: checked expressions of channels, evaluated sample by sample."""
