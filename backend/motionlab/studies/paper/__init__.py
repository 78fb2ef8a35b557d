"""The paper's printed numbers beside what is computed here, each with its band and its reason."""
