"""The paper's printed numbers beside computed ones, each with a band and its reason."""
