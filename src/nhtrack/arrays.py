"""Array type of the package and the shape checks its public functions share."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

# NumPy today, any array-API library tomorrow: functions ask `namespace` for the module to compute with.
Array: TypeAlias = Any


def namespace(*arrays: Array) -> Any:
    """Returns the array-API namespace shared by the given arrays."""
    if all(isinstance(array, np.ndarray | np.generic) for array in arrays):
        return np  # the standard's own functions; the wrapper of them takes a third of a second to import
    import array_api_compat

    return array_api_compat.array_namespace(*arrays)


def require_last_axis(name: str, array: Array, size: int) -> None:
    """Raises ValueError unless the last axis of `array` has `size` components."""
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(f"{name}: expected shape (..., {size}), got {tuple(array.shape)}")
