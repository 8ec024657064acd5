"""How kernels are compiled: the few functions that numba makes fast."""

from __future__ import annotations

from typing import Any

from numba import njit

_NO_COUNTS: dict[str, Any] = {"_nrt": False}  # an option that numba's types do not know

# They neither raise nor make arrays. So nobody has to count who uses the arrays that they are given, which costs
# up to ten times more than what they do.
kernel = njit(cache=True, error_model="numpy", **_NO_COUNTS)

# The same for small ones that become part of those that call them.
inlined = njit(cache=True, error_model="numpy", inline="always", **_NO_COUNTS)

# Those that make arrays.
maker = njit(cache=True, error_model="numpy")
