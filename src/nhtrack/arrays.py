"""The array type of the package, what is computed with it, and the shape checks its public functions share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol, TypeAlias, cast

import numpy as np
import numpy.typing as npt

# Written as NumPy's, which is what the package makes; `se2` and the reduced model take arrays of any array-API library.
Array: TypeAlias = npt.NDArray[Any]
Operand: TypeAlias = Array | float

CHUNK = 1024  # rows at most that large arrays are cut into on a disk
_BLOCK = 2**24  # bytes of a large array that are looked at at a time


class Namespace(Protocol):
    """The functions of the array API that the package uses."""

    float64: Any

    def abs(self, x: Array, /) -> Array: ...  # noqa: D102 - see the array API
    def asarray(self, obj: Any, /, *, dtype: Any = None) -> Array: ...  # noqa: D102
    def broadcast_arrays(self, *arrays: Array) -> Sequence[Array]: ...  # noqa: D102
    def ceil(self, x: Array, /) -> Array: ...  # noqa: D102
    def clip(self, x: Array, /, min: Any = None, max: Any = None) -> Array: ...  # noqa: D102
    def cos(self, x: Array, /) -> Array: ...  # noqa: D102
    def full_like(self, x: Array, /, fill_value: float) -> Array: ...  # noqa: D102
    def hypot(self, x1: Array, x2: Array, /) -> Array: ...  # noqa: D102
    def maximum(self, x1: Operand, x2: Operand, /) -> Array: ...  # noqa: D102
    def minimum(self, x1: Operand, x2: Operand, /) -> Array: ...  # noqa: D102
    def ones_like(self, x: Array, /) -> Array: ...  # noqa: D102
    def round(self, x: Array, /) -> Array: ...  # noqa: D102
    def sign(self, x: Array, /) -> Array: ...  # noqa: D102
    def sin(self, x: Array, /) -> Array: ...  # noqa: D102
    def stack(self, arrays: Sequence[Array], /, *, axis: int = 0) -> Array: ...  # noqa: D102
    def where(self, condition: Array, x1: Operand, x2: Operand, /) -> Array: ...  # noqa: D102
    def zeros(self, shape: tuple[int, ...], /) -> Array: ...  # noqa: D102
    def zeros_like(self, x: Array, /) -> Array: ...  # noqa: D102


def namespace(*arrays: Operand) -> Namespace:
    """Returns the array-API namespace shared by the given arrays."""
    if all(isinstance(array, np.ndarray | np.generic) for array in arrays):
        return cast(Namespace, np)  # has the standard's functions itself; a wrapper takes a third of a second to import
    import array_api_compat

    return cast(Namespace, array_api_compat.array_namespace(*arrays))


def require_last_axis(name: str, array: Array, size: int) -> None:
    """Raises ValueError unless the last axis of `array` has `size` components."""
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(f"{name}: expected shape (..., {size}), got {tuple(array.shape)}")


def row_blocks(rows: int, size: int, block: int = _BLOCK) -> Iterator[slice]:
    """Yields slices of the rows of an array of so many bytes, in order, each of about `block` bytes at most."""
    step = max(1, block * rows // max(size, 1))
    step -= step % CHUNK if step > CHUNK else 0
    yield from (slice(first, min(first + step, rows)) for first in range(0, rows, step))
