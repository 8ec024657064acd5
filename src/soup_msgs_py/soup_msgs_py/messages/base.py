"""How messages are made: frozen for the type checker, which costs nothing while they run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from typing_extensions import dataclass_transform

Point = tuple[float, float]
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

_Class = TypeVar("_Class", bound=type[Any])


@dataclass_transform(frozen_default=True)
def message(cls: _Class) -> _Class:
    """A dataclass with slots that is never changed; equal if all fields are.

    Setting the fields of a truly frozen one takes three times as long, and a run makes some hundred thousand.
    """
    return dataclass(slots=True, unsafe_hash=True)(cls)


@dataclass_transform(frozen_default=True, eq_default=False)
def message_of_arrays(cls: _Class) -> _Class:
    """The same for one that holds arrays: equal only to itself."""
    return dataclass(slots=True, eq=False)(cls)
