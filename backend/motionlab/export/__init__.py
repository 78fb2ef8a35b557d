"""Generated code: a scenario's controller as portable C99, and its motor as an FMU."""
