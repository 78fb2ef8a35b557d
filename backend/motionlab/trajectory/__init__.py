"""References: geometry, time laws, sampling and feasibility."""
