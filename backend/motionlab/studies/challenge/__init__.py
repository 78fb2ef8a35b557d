"""The challenge: laws of friction compensation on frozen scenarios and hidden motors, ranked."""
