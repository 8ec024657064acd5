"""How kernels are compiled: the few functions that numba makes fast."""

from __future__ import annotations

from numba import njit

# They neither raise nor make arrays. So nobody has to count who uses the arrays that they are given, which costs
# up to ten times more than what they do.
kernel = njit(cache=True, error_model="numpy", _nrt=False)

# The same for small ones that become part of those that call them.
inlined = njit(cache=True, error_model="numpy", _nrt=False, inline="always")

# Those that make arrays.
maker = njit(cache=True, error_model="numpy")
