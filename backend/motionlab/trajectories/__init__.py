"""References: geometry, motion profiles, sampling and feasibility."""
