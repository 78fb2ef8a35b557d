"""Generated code: a controller as portable C99 or as an FMU, and the motor as an FMU."""
