"""What all tests share."""

from __future__ import annotations

from hypothesis import settings

# compilation and a noisy machine make single examples slow; time is never what a test asserts
settings.register_profile("warehouse", deadline=None)
settings.load_profile("warehouse")
