"""The model for other targets, made from the lane functions."""
