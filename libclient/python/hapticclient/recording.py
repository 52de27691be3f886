"""Recordings of a device."""
from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

from . import _abi, arrays
from .errors import call
from .handle import Handle

_lib = _abi.lib


class RecordingEnd(NamedTuple):
    """How a recording ended."""
    cycles: int
    lost: int
    reason: str


class Recording(Handle):
    """A recording under way: a stream to be read, on another thread, until its end. Close it or use `with`."""
    _kind = "recording"
    _release = _lib.haptic_recording_close

    def __init__(self, client: Any, uri: str) -> None:
        handle = ctypes.c_void_p()
        self._client = client  # kept while the recording is
        call(_lib.haptic_recording_start, client._handle, arrays.device(uri), ctypes.byref(handle))
        super().__init__(handle)

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
