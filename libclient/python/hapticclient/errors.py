"""Refusals as exceptions."""
from __future__ import annotations

import ctypes
import enum
import re
from typing import Any

from . import _abi


class Code(enum.IntEnum):
    """Kinds of refusal: `code` of a HapticError, whose `what` says more."""
    OK = 0
    INVALID_ARGUMENT = 1
    NOT_FOUND = 2
    ALREADY_EXISTS = 3
    PERMISSION_DENIED = 4
    QUOTA_EXCEEDED = 5
    VERSION_MISMATCH = 6
    LEASE_REQUIRED = 7
    LEASE_HELD = 8
    FAULT_LATCHED = 10
    DEVICE_GONE = 11
    DEVICE_BUSY = 12
    STILL_MAPPED = 13
    BAD_MESH = 14
    BAD_SNAPSHOT = 15
    BUILDER_FAILED = 16
    WOULD_BLOCK = 17
    DISCONNECTED = 18
    NO_REALTIME = 19
    SYSTEM = 20
    UNSUPPORTED = 21
    TIMEOUT = 22
    CANCELLED = 23
    INTERNAL = 24


class HapticError(Exception):
    """A refusal: `code` says what kind, `where` the place, `what` the fault, `remedy` what to do."""

    def __init__(self, code: int, where: str = "", what: str = "", remedy: str = "") -> None:
        try:
            self.code: int = Code(code)
        except ValueError:  # of a newer daemon
            self.code = code
        self.where = where
        self.what = what or _abi.lib.haptic_error_text(code).decode()
        self.remedy = remedy
        message = f"{where}: {self.what}" if where else self.what
        super().__init__(f"{message} ({remedy})" if remedy else message)


#: What the library's words of C are called here.
_OURS = {
    "HAPTIC_OBJECT_ENABLED, _VISIBLE and _TWO_SIDED": "ObjectFlag.ENABLED, .VISIBLE and .TWO_SIDED",
    "HAPTIC_PUSH_LATEST": "latest=True",
    "haptic_effect_kind": "EffectKind",
    "haptic_object_find()": "Scene.find()",
    "haptic_reconnect()": "Client.reconnect()",
    "haptic_session_info.": "Session.describe().",
    "haptic_session_reopen()": "Session.reopen()",
    "haptic_shape_kind": "ShapeKind",
    # Structures, whose fields are arguments.
    **{f"haptic_{name}.": "" for name in ("connect_options", "device_limits", "effect", "events_options", "object",
                                          "session_options", "surface", "vibration")},
}
_C_WORDS = re.compile("|".join(map(re.escape, _OURS)))


def _in_python(text: bytes) -> str:
    """The library's text, with this package's names for what it names."""
    return _C_WORDS.sub(lambda word: _OURS[word[0]], text.decode("utf-8", "replace"))


def check(code: int) -> None:
    """Raises unless the code of a call without words is OK."""
    if code != 0:
        gone = code == Code.DISCONNECTED
        raise HapticError(code, remedy="Client.reconnect() and Session.reopen(), or open another" if gone else "")


def call(function: Any, *arguments: Any) -> None:
    """Calls a function whose last parameter is the error; raises what it says."""
    error = _abi.Error()
    code = function(*arguments, ctypes.byref(error))
    if code != 0:
        raise HapticError(code, *(_in_python(getattr(error, name)) for name in ("where", "what", "remedy")))
