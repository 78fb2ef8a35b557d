"""Generated code: a scenario's controller as portable C99 and as an FMU, and its motor as an FMU."""
