"""Why an error peaks: each cause taken away, and the smallest change that mends it."""
