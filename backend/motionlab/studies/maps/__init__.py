"""Force maps by finite elements: computed once, then kept."""
