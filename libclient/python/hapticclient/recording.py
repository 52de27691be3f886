"""Recordings of a device."""
from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

from . import _abi, arrays
from .errors import call

_lib = _abi.lib


class RecordingEnd(NamedTuple):
    """How a recording ended."""
    cycles: int
    lost: int
    reason: str


class Recording:
    """A recording under way: a stream to be read, on another thread, until its end. Close it or use `with`."""

    def __init__(self, client: Any, uri: str) -> None:
        self._handle = ctypes.c_void_p()
        self._client = client  # kept while the recording is
        call(_lib.haptic_record, client._handle, arrays.text(uri), ctypes.byref(self._handle))

    def fileno(self) -> int:
        """The descriptor to read from; the recording's own."""
        return int(_lib.haptic_recording_fd(self._handle))

    def stop(self) -> RecordingEnd:
        """Ends it; all of it is in the stream then."""
        out = ctypes.c_void_p()
        call(_lib.haptic_recording_stop, self._handle, ctypes.byref(out))
        try:
            end = _abi.RecordingEnd.from_address(out.value)
            return RecordingEnd(end.cycles, end.lost, end.reason.decode())
        finally:
            _lib.haptic_free(out)

    def close(self) -> None:
        """Ends it, if it has not ended, and frees it."""
        _lib.haptic_recording_close(self._handle)
        self._handle = ctypes.c_void_p()

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()
