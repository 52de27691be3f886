"""What all handles of the library have in common."""
from __future__ import annotations

from typing import Any, Optional, TypeVar

from .errors import Code, HapticError

T = TypeVar("T", bound="Handle")


class Handle:
    """Ends with close(), with its `with` block, or with the last reference to it; says so to who comes later.

    No other thread may be in a call on it when it ends.
    """
    _kind: str
    _release: Any  # The library's function that takes it back.

    def __init__(self, handle: Any) -> None:
        self._open: Optional[Any] = handle

    @property
    def _handle(self) -> Any:
        if self._open is None:
            raise HapticError(Code.INVALID_ARGUMENT, self._kind, "is closed", "open another one")
        return self._open

    def __repr__(self) -> str:
        return f"<{type(self).__name__}, {'closed' if self._open is None else 'open'}>"

    def __enter__(self: T) -> T:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()

    def close(self) -> None:
        """Ends it; once more does nothing."""
        handle, self._open = getattr(self, "_open", None), None
        if handle is not None:
            self._release(handle)
