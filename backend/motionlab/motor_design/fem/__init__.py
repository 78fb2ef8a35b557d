"""Force maps by finite elements: thrust and normal force of one phase over position and current."""
