"""Arrays as commands and files take them; the native part reads numpy's itself."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def rows(values: npt.ArrayLike, width: int, what: str) -> tuple[Array, bool]:
    """Values as rows of `width`, and whether it was a single one."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim == 1 and array.size == width:
        return array.reshape(1, width), True
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{what}: an array of shape {array.shape}; expected (n, {width}) or ({width},)")
    return array, False


def finite(values: Array, what: str) -> Array:
    """The values, if all of them are finite: a file cannot hold others."""
    if not np.isfinite(values).all():
        row = int(np.argwhere(~np.isfinite(values))[0][0])
        raise ValueError(f"{what}: row {row} has a number that is not finite")
    return values
