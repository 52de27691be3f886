"""Arrays and texts as the library takes them; what would be cut off or taken apart is refused."""
from __future__ import annotations

import ctypes
import operator
from collections.abc import Iterable
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt


def whole(value: SupportsIndex, bits: int, what: str) -> int:
    """A number from 0 that fits; ctypes cuts off what is too long: mesh 2^64 + 5 would be mesh 5."""
    try:
        given = operator.index(value)
    except TypeError:
        raise TypeError(f"{what}: a whole number is needed, not {value!r}") from None
    if not 0 <= given < 1 << bits:
        raise ValueError(f"{what}: {given} is out of range")
    return given


def vector(values: Iterable[float], what: str, length: int = 3) -> Any:
    """So many numbers for the library."""
    try:
        numbers = [float(value) for value in values]
    except (TypeError, ValueError):
        raise TypeError(f"{what}: {length} numbers are needed, not {values!r}") from None
    if len(numbers) != length:
        raise ValueError(f"{what}: {length} numbers are needed, not {len(numbers)}")
    return (ctypes.c_double * length)(*numbers)


def ns(seconds: float, what: str) -> int:
    """A time for the library; beyond three centuries it has none."""
    if not abs(seconds) < 9e9:  # Nor is NaN.
        raise ValueError(f"{what}: {seconds} is no time in seconds")
    return round(seconds * 1e9)


def us(seconds: float, what: str) -> int:
    """The same in 32 bits of microseconds, of which whatever is not zero makes one at least."""
    if not 0 <= seconds <= 4294:
        raise ValueError(f"{what}: {seconds} is not a time from 0 to 4294 seconds")
    return max(round(seconds * 1e6), int(seconds > 0))


def text(value: str, needed: str = "a text") -> bytes:
    """UTF-8; the library would read it up to a zero, another name than was given."""
    if not isinstance(value, str):
        raise TypeError(f"{needed} is needed, not {value!r}")
    if "\0" in value:
        raise ValueError(f"a zero byte in {value!r}")
    return value.encode()


def device(value: str) -> bytes:
    """What a device is named by: no place in a list."""
    return text(value, "a URI, name or serial")


def points(values: npt.ArrayLike, what: str) -> npt.NDArray[np.float32]:
    """n x 3 numbers, or 3 n in a row."""
    given = np.asarray(values, np.float32)
    if given.ndim > 2 or (given.ndim == 2 and given.shape[1] != 3) or given.size % 3 != 0:
        raise ValueError(f"{what}: n x 3 numbers are needed, not {' x '.join(map(str, given.shape))}")
    return np.ascontiguousarray(given.reshape(-1, 3))


def indices(values: npt.ArrayLike, what: str) -> npt.NDArray[np.uint32]:
    """Whole numbers from 0, of any shape."""
    given = np.asarray(values)
    if given.size and given.dtype.kind not in "iu":
        if given.dtype.kind != "f" or not (given == np.floor(given)).all():
            raise ValueError(f"{what}: an index is no whole number")
    if given.size and (given.min() < 0 or given.max() > 0xffffffff):
        raise ValueError(f"{what}: an index is negative or too large")
    return np.ascontiguousarray(given.astype(np.uint32))


def corners(values: npt.ArrayLike, what: str) -> npt.NDArray[np.uint32]:
    """m x 3 indices, or 3 m in a row."""
    given = indices(values, what)
    if given.ndim > 2 or (given.ndim == 2 and given.shape[1] != 3) or given.size % 3 != 0:
        raise ValueError(f"{what}: m x 3 indices are needed, not {' x '.join(map(str, given.shape))}")
    return given.reshape(-1, 3)


def pixels(values: npt.ArrayLike, what: str) -> npt.NDArray[np.uint16]:
    """Rows of a grey picture: 1 is white, 0 black; uint8 and uint16, in whatever order of bytes, as they are."""
    given = np.asarray(values)
    if given.ndim != 2:
        raise ValueError(f"{what}: rows and columns are needed, one number a pixel")
    if given.dtype == np.uint8:
        return given.astype(np.uint16) * 257
    if given.dtype.kind != "u" or given.dtype.itemsize != 2:
        if not ((given >= 0) & (given <= 1)).all():
            raise ValueError(f"{what}: a value is not between 0 and 1")
        given = np.round(given.astype(np.float64) * 65535)  # White is more than a float16 can hold.
    return np.ascontiguousarray(given, np.uint16)
