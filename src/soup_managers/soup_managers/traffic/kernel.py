"""How the functions of this package are compiled."""

from __future__ import annotations

from numba import njit

# Nothing raises: then arrays need no reference counts, which would cost more than the searches themselves.
kernel = njit(cache=True, error_model="numpy")
