"""hapticclient: programs that touch, in Python.

    import hapticclient as haptic

    with haptic.Client() as client, client.open_session() as session:
        session.arm()
        session.push_plane((0, 0, 0), (0, 0, 1), lease_s=2.0)
        print(session.latest()["force"])

SI units; x toward the operator, y to the operator's right, z up; quaternions w, x, y, z. Needs numpy and
libhapticclient.so.1.
"""
from . import _abi
from .client import Client, Events, Frame, Scene, convert
from .errors import Code, HapticError
from .recording import Recording, RecordingEnd
from .session import HISTORY, SAMPLE, Session
from .types import (Ability, Acks, Calibration, Check, ClientStatus, Counters, DaemonInfo, DeviceInfo, DeviceLimits,
                    DeviceStatus, EffectKind, Event, EventKind, Fault, Histogram, Material, MeshReport, ModelStatus, ObjectFlag,
                    ObjectState, Pose, SampleFlag, SessionInfo, ShapeKind, Source, Statistics, Status, Surface,
                    TextureReport, VibrationModel)

__version__: str = _abi.lib.haptic_version().decode()
__all__ = [
    "Ability", "Acks", "Calibration", "Check", "Client", "ClientStatus", "Code", "Counters", "DaemonInfo", "DeviceInfo",
    "DeviceLimits", "DeviceStatus", "EffectKind", "Event", "EventKind", "Events", "Fault", "Frame", "HISTORY", "HapticError",
    "Histogram", "Material", "MeshReport", "ModelStatus", "ObjectFlag", "ObjectState", "Pose", "Recording",
    "RecordingEnd", "SAMPLE", "SampleFlag", "Scene", "Session", "SessionInfo", "ShapeKind", "Source", "Statistics",
    "Status", "Surface", "TextureReport", "VibrationModel", "convert"
]
