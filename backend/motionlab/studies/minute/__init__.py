"""What another law would have done in a recorded stretch."""
