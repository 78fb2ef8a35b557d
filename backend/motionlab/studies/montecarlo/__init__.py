"""Monte Carlo studies: many plausible plants under the same controllers."""
