"""C structures as the plain Python values of types.py."""
from __future__ import annotations

import ctypes
from dataclasses import fields
from typing import Any, TypeVar

from . import _abi
from .types import (Ability, ClientStatus, DaemonInfo, DeviceInfo, DeviceLimits, DeviceStatus, Material, MeshReport,
                    ObjectFlag, ObjectState, Pose, ShapeKind, Status, Surface, TextureReport)

T = TypeVar("T")

_BOOLEANS = {"open", "armed", "administration", "realtime", "lease", "closed", "ended"}


def _value(raw: Any) -> Any:
    if isinstance(raw, bytes):
        return raw.decode("utf-8", "replace")
    if isinstance(raw, ctypes.Array):
        return tuple(raw)
    if isinstance(raw, _abi.Pose):
        return Pose(tuple(raw.p), tuple(raw.q))
    return raw


def plain(cls: type[T], raw: Any, **more: Any) -> T:
    """Copies the fields of a C structure that `cls` names; `more` gives those that need care."""
    values = dict(more)
    for field in fields(cls):  # type: ignore[arg-type]
        if field.name not in values:
            value = _value(getattr(raw, field.name))
            values[field.name] = bool(value) if field.name in _BOOLEANS else value
    return cls(**values)


def device_info(raw: Any) -> DeviceInfo:
    return plain(DeviceInfo, raw, abilities=Ability(raw.abilities))


def mesh_report(raw: Any) -> MeshReport:
    return plain(MeshReport, raw, notes=[raw.notes[i].decode() for i in range(raw.note_count)])


def texture_report(raw: Any) -> TextureReport:
    return plain(TextureReport, raw, relief=bool(raw.relief))


def _shape_kind(number: int) -> int:
    try:
        return ShapeKind(number)
    except ValueError:  # of a newer daemon
        return number


def object_state(raw: Any) -> ObjectState:
    made = raw.object.contents
    return plain(ObjectState, raw, name=made.name.decode(), parent=made.parent.decode(),
                 flags=ObjectFlag(made.flags), pose=_value(made.pose), shape=_shape_kind(made.shape.kind),
                 size=tuple(made.shape.size), mesh=made.shape.mesh,
                 material=Material(*(getattr(made.material, name) for name in Material._fields)),
                 surface=plain(Surface, raw.surface.contents))


def status(raw: Any) -> Status:
    devices = [plain(DeviceStatus, entry, limits=plain(DeviceLimits, entry.limits.contents))
               for entry in (raw.devices[i].contents for i in range(raw.device_count))]
    clients = [plain(ClientStatus, raw.clients[i].contents) for i in range(raw.client_count)]
    return plain(Status, raw, info=plain(DaemonInfo, raw.info.contents), devices=devices, clients=clients)
