"""Which friction model a record supports: fits, held-out errors, and what cannot be told."""
