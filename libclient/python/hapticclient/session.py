"""A session with a device: numpy views of what the servo does, and pushes at the program's own pace."""
from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any, Optional, SupportsIndex

import numpy as np
import numpy.typing as npt

from . import _abi, arrays
from .convert import device_info, plain
from .errors import Code, HapticError, call, check
from .handle import Handle
from .types import Acks, Counters, Material, ModelStatus, SessionInfo

#: One servo sample; Session.latest() tells the fields.
SAMPLE = np.dtype(_abi.SAMPLE_FIELDS)

#: Samples that the daemon keeps; drain() before they are overwritten.
HISTORY = 1024

#: Commands that can wait to be taken.
RING = 256

PLANE, SPRING, SPHERE, HALFSPACES, CORNER = 1, 2, 3, 4, 5
_lib = _abi.lib


def raw_material(material: Material) -> Any:
    """Four numbers, or the first of them."""
    try:
        return _abi.Material(**Material(*material)._asdict())
    except TypeError:
        raise TypeError(f"material: haptic.Material(N/m, N s/m, mu_s, mu_d) is needed, not {material!r}") from None


def _object(object_id: SupportsIndex) -> int:
    """Its number. Who gives its name, as Scene takes it, is told where that has one."""
    if isinstance(object_id, str):
        raise TypeError(f"object_id: a number is needed, not {object_id!r}; Scene.find({object_id!r}).id is its")
    return arrays.whole(object_id, 32, "object_id")


class Session(Handle):
    """Made by Client.open_session(). Ends with its `with` block or close(): its share of the force fades, its lease ends.

    One thread at a time reads, one at a time pushes. Pushes take `latest=True` (a mailbox: only the newest value
    matters; not those that change a part, flags and vertices) or `at_tick` (the ring: takes effect at that tick); they
    return the command's number. Without `device` they are for the session's own, of those that share its servo.

    In m, N, N m, m/s and rad/s; quaternions are w, x, y, z. `frame` is 0 for the world, else an object's id: then origin,
    normal, half-spaces, x0, f0 and Jacobian are in its frame and move along with it. What `lease_s` (at most 10 s) has not
    seen renewed fades; a new one replaces what its slot had over `blend_s` (at most 1 s, and less than 5 ms is 5 ms).
    """

    _kind = "session"
    _release = _lib.haptic_session_close

    def __init__(self, handle: ctypes.c_void_p, client: Any) -> None:
        super().__init__(handle)
        self._client = client  # keeps the connection as long as the session
        self._lost = ctypes.c_uint64(0)
        self._own: Optional[int] = None  # number of its device in the group

    def describe(self) -> SessionInfo:
        """Its number, the period of the servo, the device."""
        out = ctypes.c_void_p()
        call(_lib.haptic_session_describe, self._handle, ctypes.byref(out))
        try:
            raw = _abi.SessionInfo.from_address(out.value)
            return plain(SessionInfo, raw, device=device_info(raw.device.contents))
        finally:
            _lib.haptic_free(out)

    def reopen(self) -> None:
        """After Client.reconnect(): the device is disarmed and nothing is pushed yet."""
        call(_lib.haptic_session_reopen, self._handle)
        self._lost.value = 0
        self._own = None

    def acquire_lease(self) -> None:
        """Reserves the right to arm; LEASE_HELD names the holder."""
        call(_lib.haptic_session_acquire_lease, self._handle)

    def release_lease(self) -> None:
        """Gives it back; the device is disarmed."""
        call(_lib.haptic_session_release_lease, self._handle)

    def arm(self) -> None:
        """Takes the lease and energises the device; the force ramps up over two seconds once what is asked for is small.

        A fault that is latched is cleared, if its cause is gone. Returns at once: SampleFlag.RAMPING tells of the ramp.
        After TIMEOUT it is not armed later either.
        """
        call(_lib.haptic_session_arm, self._handle)

    def disarm(self) -> None:
        """Has the force lowered, in a second at most."""
        call(_lib.haptic_session_disarm, self._handle)

    @property
    def alive(self) -> bool:
        """Whether the session lives."""
        return _lib.haptic_session_check(self._open) == 0

    # ---------------------------------------------------------------- reading

    def latest(self, device: Optional[int] = None) -> np.void:
        """The newest sample: latest()["p"], latest()["force"], ... HapticError WOULD_BLOCK while there is none.

        World frame, SI. tick, t_ns (CLOCK_MONOTONIC); device, flags (SampleFlag), fault (Fault), buttons; p, q, v, w: the
        hand's place, orientation, velocity, angular velocity; proxy; force and torque sent, by_source[Source.SURFACE], ...
        which sum to force; own: this session's share; gripper_rad, gripper_force_n; energy_j: what the passivity observer
        holds; depth_m below the surface; contact_object, 0 for none; missed periods; wake_ns, cycle_ns; applied_commands.
        `device` is another one of the group, by its place there.
        """
        sample = np.empty(1, SAMPLE)
        if device is None:
            code = _lib.haptic_session_latest(self._handle, sample.ctypes.data)
        else:
            code = _lib.haptic_session_latest_of(self._handle, arrays.whole(device, 32, "device"), sample.ctypes.data)
        if code == Code.WOULD_BLOCK:
            raise HapticError(code, "latest", "no sample can be had: the servo has not run yet", "ask again")
        check(code)
        return sample[0]

    def drain(self, out: Optional[npt.NDArray[np.void]] = None) -> npt.NDArray[np.void]:
        """The oldest unread samples, in order: a view of `out`, else of a new array. `lost` counts what was missed.

        Of all devices that share the servo: samples["device"] says whose each is, describe().device_index which is its own.
        """
        if out is None:
            out = np.empty(HISTORY, SAMPLE)
        elif out.dtype != SAMPLE or not out.flags.c_contiguous or not out.flags.writeable or out.ndim != 1:
            raise ValueError("out: a contiguous, writable array of dtype SAMPLE is needed")
        count = ctypes.c_uint32()
        check(_lib.haptic_session_drain(self._handle, out.ctypes.data, len(out), ctypes.byref(count),
                                        ctypes.byref(self._lost)))
        return out[:count.value]

    @property
    def lost(self) -> int:
        """Samples overwritten before drain() came, since the session was opened or reopened."""
        return self._lost.value

    def acks(self) -> Acks:
        """What became of the commands pushed: the last one taken, how many were refused, and why."""
        raw = _abi.Acks()
        check(_lib.haptic_session_acks(self._handle, ctypes.byref(raw)))
        return plain(Acks, raw)

    def counters(self) -> Counters:
        """Counters of the servo since its start."""
        raw = _abi.Counters()
        check(_lib.haptic_session_counters(self._handle, ctypes.byref(raw)))
        return plain(Counters, raw)

    def model(self, slot: int) -> ModelStatus:
        """What the servo does with the local model or force field in a slot."""
        raw = _abi.ModelStatus()
        check(_lib.haptic_session_model_status(self._handle, arrays.whole(slot, 32, "slot"), ctypes.byref(raw)))
        return plain(ModelStatus, raw)

    # ---------------------------------------------------------------- pushing

    def _push(self, function: Any, command: Any, latest: bool, at_tick: int) -> int:
        push = _abi.Push(at_tick=at_tick, flags=1 if latest else 0)
        if function(self._handle, ctypes.byref(command), ctypes.byref(push)) != Code.OK:
            call(_lib.haptic_push_refusal, self._handle)
        return push.seq

    def _number(self, device: Optional[int]) -> int:
        """Of a device in the group: this session's own if none is named."""
        if device is not None:
            return device
        if self._own is None:
            self._own = self.describe().device_index
        return self._own

    @property
    def space(self) -> int:
        """Commands that the ring takes now."""
        return _lib.haptic_push_space(self._open)

    def push_plane(self, origin: Sequence[float], normal: Sequence[float], *, slot: int = 0,
                   material: Material = Material(), lease_s: float = 0.5, blend_s: float = 0.02, frame: int = 0,
                   device: Optional[int] = None, latest: bool = False, at_tick: int = 0) -> int:
        """Solid behind the plane: plane and probe."""
        model = self._model(PLANE, slot, material, lease_s, blend_s, frame, device, origin)
        model.normal = arrays.vector(normal, "normal")
        return self._push(_lib.haptic_push_local_model, model, latest, at_tick)

    def push_spring(self, origin: Sequence[float], *, free_length: float = 0.0, slot: int = 0,
                    material: Material = Material(), lease_s: float = 0.5, blend_s: float = 0.02, frame: int = 0,
                    device: Optional[int] = None, latest: bool = False, at_tick: int = 0) -> int:
        """A spring from the device point to `origin`."""
        model = self._model(SPRING, slot, material, lease_s, blend_s, frame, device, origin)
        model.radius = free_length
        return self._push(_lib.haptic_push_local_model, model, latest, at_tick)

    def push_sphere(self, origin: Sequence[float], radius: float, *, slot: int = 0, material: Material = Material(),
                    lease_s: float = 0.5, blend_s: float = 0.02, frame: int = 0, device: Optional[int] = None,
                    latest: bool = False, at_tick: int = 0) -> int:
        """A solid sphere; a negative radius keeps the hand inside."""
        model = self._model(SPHERE, slot, material, lease_s, blend_s, frame, device, origin)
        model.radius = radius
        return self._push(_lib.haptic_push_local_model, model, latest, at_tick)

    def push_halfspaces(self, origin: Sequence[float], halfspaces: npt.ArrayLike, *, corner: bool = False, slot: int = 0,
                        material: Material = Material(), lease_s: float = 0.5, blend_s: float = 0.02, frame: int = 0,
                        device: Optional[int] = None, latest: bool = False, at_tick: int = 0) -> int:
        """Rows of unit normal and offset: solid where n.(x - origin) <= d for all of them, or for any (`corner`)."""
        rows = np.asarray(halfspaces, np.float32)
        if rows.ndim != 2 or rows.shape[1] != 4 or not 1 <= len(rows) <= 16:
            raise ValueError("halfspaces: 1 to 16 rows of 4 numbers are needed")
        model = self._model(CORNER if corner else HALFSPACES, slot, material, lease_s, blend_s, frame, device, origin)
        model.count = len(rows)
        for i, row in enumerate(rows):
            model.halfspace[i] = (ctypes.c_float * 4)(*row)
        return self._push(_lib.haptic_push_local_model, model, latest, at_tick)

    def _model(self, kind: int, slot: int, material: Material, lease_s: float, blend_s: float, frame: int,
               device: Optional[int], origin: Sequence[float]) -> Any:
        return _abi.LocalModel(slot=slot, kind=kind, frame=frame, device=self._number(device),
                               lease_ns=arrays.ns(lease_s, "lease_s"), blend_ns=arrays.ns(blend_s, "blend_s"),
                               material=raw_material(material), origin=arrays.vector(origin, "origin"))

    def push_force_field(self, x0: Sequence[float], f0: Sequence[float], jacobian: npt.ArrayLike, radius: float, *,
                         slot: int = 0, lease_s: float = 0.1, blend_s: float = 0.01, frame: int = 0,
                         device: Optional[int] = None, latest: bool = False, at_tick: int = 0) -> int:
        """Force f0 + J (x - x0) within `radius` of x0; the Jacobian lets the servo go on between two pushes."""
        field = _abi.ForceField(slot=slot, frame=frame, device=self._number(device),
                                lease_ns=arrays.ns(lease_s, "lease_s"), blend_ns=arrays.ns(blend_s, "blend_s"),
                                x0=arrays.vector(x0, "x0"), f0=arrays.vector(f0, "f0"), radius=radius,
                                jacobian=arrays.vector(np.asarray(jacobian, float).reshape(-1), "jacobian", 9))
        return self._push(_lib.haptic_push_force_field, field, latest, at_tick)

    def clear_model(self, slot: int, *, blend_s: float = 0.02, latest: bool = False, at_tick: int = 0) -> int:
        """Fades a local model or force field out over `blend_s`."""
        return self._push(_lib.haptic_push_clear_model, _abi.ClearModel(slot=slot, blend_ns=arrays.ns(blend_s, "blend_s")),
                          latest, at_tick)

    def push_force(self, force: Sequence[float], torque: Sequence[float] = (0, 0, 0), *, lease_s: float = 0.05,
                   device: Optional[int] = None, latest: bool = False, at_tick: int = 0) -> int:
        """A plain force in the world, held until replaced or until the lease runs out."""
        command = _abi.ClientForce(device=self._number(device), lease_ns=arrays.ns(lease_s, "lease_s"),
                                   force=arrays.vector(force, "force"), torque=arrays.vector(torque, "torque"))
        return self._push(_lib.haptic_push_client_force, command, latest, at_tick)

    def push_intent(self, p: Sequence[float], q: Sequence[float] = (1, 0, 0, 0), *, gripper_rad: float = 0.0,
                    device: Optional[int] = None, latest: bool = False, at_tick: int = 0) -> int:
        """Where in the world the hand of a simulated device wants to be."""
        command = _abi.Intent(device=self._number(device), p=arrays.vector(p, "p"), q=arrays.vector(q, "q", 4),
                              gripper_rad=gripper_rad)
        return self._push(_lib.haptic_push_intent, command, latest, at_tick)

    def push_limits(self, force_n: float, torque_nm: float, *, latest: bool = False, at_tick: int = 0) -> int:
        """Binds this session's own share; can only lower what the daemon allows. 0 takes it away."""
        return self._push(_lib.haptic_push_limits, _abi.SessionLimits(force_n=force_n, torque_nm=torque_nm), latest, at_tick)

    def push_object_pose(self, object_id: int, p: Sequence[float], q: Sequence[float] = (1, 0, 0, 0),
                         v: Sequence[float] = (0, 0, 0), w: Sequence[float] = (0, 0, 0), *, lease_s: float = 0,
                         latest: bool = False, at_tick: int = 0) -> int:
        """Moves an object in its parent's frame; the servo goes on with the velocity until the next push, for
        `lease_s` at most if that is given: without it a program that hangs leaves the object moving."""
        command = _abi.ObjectPose(object=_object(object_id), lease_us=arrays.us(lease_s, "lease_s"), p=arrays.vector(p, "p"),
                                  q=arrays.vector(q, "q", 4), v=arrays.vector(v, "v"), w=arrays.vector(w, "w"))
        return self._push(_lib.haptic_push_object_pose, command, latest, at_tick)

    def push_object_material(self, object_id: int, material: Material, *, latest: bool = False,
                             at_tick: int = 0) -> int:
        """Changes how an object feels from one tick to the next."""
        command = _abi.ObjectMaterial(object=_object(object_id), material=raw_material(material))
        return self._push(_lib.haptic_push_object_material, command, latest, at_tick)

    def push_object_flags(self, object_id: int, mask: int, value: int, *, at_tick: int = 0) -> int:
        """Sets the masked bits of ObjectFlag to those of `value`."""
        command = _abi.ObjectFlags(object=_object(object_id), mask=mask, value=value)
        return self._push(_lib.haptic_push_object_flags, command, False, at_tick)

    def push_object_vertices(self, object_id: int, indices: npt.ArrayLike, places: npt.ArrayLike, *,
                             at_tick: int = 0) -> int:
        """Moves vertices of a deformable mesh, 26 a command, 6656 a call.

        WOULD_BLOCK, and nothing sent, if the ring lacks room. Of 8 commands that may wait for their `at_tick` this
        takes one for each 26 vertices; the others are refused, see acks().
        """
        index = arrays.indices(indices, "indices").reshape(-1)
        place = arrays.points(places, "places")
        if len(index) != len(place) or len(index) == 0:
            raise ValueError("as many places as indices are needed, at least one")
        if len(index) > RING * 26:
            raise ValueError(f"{len(index)} vertices: the ring never has room for more than {RING * 26} at once")
        if self.space < -(-len(index) // 26):
            check(_lib.haptic_session_check(self._handle))
            raise HapticError(Code.WOULD_BLOCK, "push", f"{RING} commands wait to be taken", "wait until space is enough")
        seq = 0
        for first in range(0, len(index), 26):
            command = _abi.ObjectVertices(object=_object(object_id), count=min(26, len(index) - first))
            for i in range(command.count):
                command.move[i].index = int(index[first + i])
                command.move[i].p = (ctypes.c_float * 3)(*place[first + i])
            seq = self._push(_lib.haptic_push_object_vertices, command, False, at_tick)
        return seq
