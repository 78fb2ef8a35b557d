"""How sure a result is: many plausible plants under the same controllers."""
