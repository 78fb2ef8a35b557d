"""Generated code: a scenario's controller as portable C99, with test vectors of the simulation."""
