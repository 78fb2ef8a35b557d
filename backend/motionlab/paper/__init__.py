"""The paper's printed numbers against computed ones, each with a band and its reason."""
