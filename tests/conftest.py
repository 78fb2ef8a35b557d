"""Settings for all tests."""

from hypothesis import settings

# The same examples on every run, and no assertion on timing.
settings.register_profile("motionlab", deadline=None, derandomize=True)
settings.load_profile("motionlab")
