"""The connection, the scene and events."""
from __future__ import annotations

import contextlib
import ctypes
import dataclasses
import json
import math
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _abi, arrays
from .convert import device_info, mesh_report, object_state, plain, status, texture_report
from .errors import Code, HapticError, call, check
from .handle import Handle
from .recording import Recording
from .session import Session, raw_material
from .types import (Check, DaemonInfo, DeviceInfo, DeviceLimits, EffectKind, Event, Histogram, Material, MeshReport, ObjectFlag,
                    ObjectState, Pose, ShapeKind, Statistics, Status, Surface, TextureReport, VibrationModel, _Chosen)

_lib = _abi.lib
_List = list  # Scene has a method of that name
Size = Union[float, Sequence[float]]


def _bytes(value: Optional[str]) -> Optional[bytes]:
    return None if value is None else arrays.text(value)


class _Reply:
    """A result of the library, freed at the end of the `with` block."""

    def __init__(self, kind: Any, function: Any, *arguments: Any) -> None:
        self._out = ctypes.c_void_p()
        call(function, *arguments, ctypes.byref(self._out))
        self._kind = kind

    def __enter__(self) -> Any:
        return self._kind.from_address(self._out.value)

    def __exit__(self, *_: object) -> None:
        _lib.haptic_free(self._out)


@contextlib.contextmanager
def _hearing(callback: Any, raised: _List[BaseException]) -> Iterator[None]:
    """What a signal's handler raises, as at Ctrl-C, as the library begins to call `callback`: Python's ctypes only tells
    of it on standard error."""
    if threading.current_thread() is not threading.main_thread():  # Handlers run nowhere else.
        yield
        return
    before = sys.unraisablehook

    def hear(unheard: Any) -> None:
        trace = unheard.exc_traceback
        if trace is not None and trace.tb_frame.f_code is callback.__code__:
            raised.append(unheard.exc_value)
        else:
            before(unheard)

    sys.unraisablehook = hear
    try:
        yield
    finally:
        if sys.unraisablehook is hear:
            sys.unraisablehook = before


def _entries(reply: Any) -> list[Any]:
    return [reply.items[i].contents for i in range(reply.count)]


def _raw_pose(pose: Pose) -> Any:
    """A place alone, three numbers, would be a pose that is not turned; whoever means one shall say so."""
    if len(pose) != 2:
        raise TypeError(f"pose: haptic.Pose((x, y, z)) or Pose((x, y, z), (w, x, y, z)) is needed, not {pose!r}")
    return _abi.Pose(p=arrays.vector(pose[0], "pose.p"), q=arrays.vector(pose[1], "pose.q", 4))


_SIZES = {ShapeKind.SPHERE: (1, "its radius"), ShapeKind.BOX: (3, "its half-extents x, y, z"),
          ShapeKind.CAPSULE: (2, "its radius and half-length"), ShapeKind.CYLINDER: (2, "its radius and half-length")}


def _raw_shape(kind: ShapeKind, size: Size, mesh: int) -> Any:
    given = np.ravel(size)
    if len(given) > 3:
        raise ValueError(f"size: at most 3 numbers, got {len(given)}")
    most, what = _SIZES.get(ShapeKind(kind), (0, "nothing"))
    if any(given[most:] != 0):  # Zeros stand there in an ObjectState, whose size fits as it is.
        raise ValueError(f"size: {ShapeKind(kind).name} takes {what}; leave out {', '.join(map(str, given[most:]))}")
    return _abi.Shape(kind=int(ShapeKind(kind)), mesh=mesh, size=arrays.vector([*given, 0.0, 0.0, 0.0][:3], "size"))


class Events(Handle):
    """A subscription. Iterate, or ask next()."""
    _kind = "subscription"
    _release = _lib.haptic_events_close

    def __init__(self, handle: ctypes.c_void_p, client: Any) -> None:
        super().__init__(handle)
        self._client = client

    def fileno(self) -> int:
        """For select(): readable while events wait. That the daemon has gone, `Client.connected` tells."""
        return _lib.haptic_events_fd(self._handle)

    def next(self, timeout_s: float = 0.0) -> Optional[Event]:
        """The oldest event, or None when none came in time. Negative: waits for ever (of a deadline give what is left, or 0)."""
        # The wait is cut into pieces so that Ctrl-C is heard.
        end = _lib.haptic_now_ns() + round(min(math.inf if timeout_s < 0 else timeout_s, 1e9) * 1e9)
        raw = _abi.Event()
        while True:
            left = max(0, end - _lib.haptic_now_ns())
            code = _lib.haptic_events_next(self._handle, ctypes.byref(raw), min(left, 200_000_000))
            if code == Code.TIMEOUT and left > 200_000_000:
                continue
            if code == Code.TIMEOUT:
                return None
            check(code)
            return plain(Event, raw)

    def __iter__(self) -> Iterator[Event]:
        """All events until the daemon goes."""
        while True:
            try:
                event = self.next(math.inf)
            except HapticError as error:
                if error.code == Code.DISCONNECTED:
                    return
                raise
            if event is not None:
                yield event


class Scene:
    """Named objects and meshes, shared by all clients."""

    def __init__(self, client: Client) -> None:
        self._client = client

    @property
    def _handle(self) -> Any:
        return self._client._handle

    def create(self, name: str, shape: ShapeKind = ShapeKind.GROUP, size: Size = (), *, mesh: int = 0,
               pose: Pose = Pose(), material: Material = Material(), parent: str = "",
               flags: ObjectFlag = ObjectFlag.ENABLED | ObjectFlag.VISIBLE) -> int:
        """Creates an object, there until it is removed or, without ObjectFlag.KEEP, the client leaves.

        Gives its number for pushes. `size` as ShapeKind tells, in metres; `mesh` is the id of an upload; `pose` is in the
        frame of the object named `parent`.
        """
        raw = _abi.Object(flags=int(flags), name=arrays.text(name), parent=arrays.text(parent), pose=_raw_pose(pose),
                          shape=_raw_shape(shape, size, mesh), material=raw_material(material))
        number = ctypes.c_uint32()
        call(_lib.haptic_object_create, self._handle, ctypes.byref(raw), ctypes.byref(number))
        return number.value

    def remove(self, name: str) -> None:
        """With its children."""
        call(_lib.haptic_object_remove, self._handle, arrays.text(name))

    def list(self) -> _List[ObjectState]:
        """All objects, whoever made them."""
        with _Reply(_abi.ObjectList, _lib.haptic_object_list_all, self._handle) as reply:
            return [object_state(entry) for entry in _entries(reply)]

    def find(self, name: str) -> ObjectState:
        """One object; HapticError NOT_FOUND if there is none of that name."""
        with _Reply(_abi.ObjectState, _lib.haptic_object_find, self._handle, arrays.text(name)) as reply:
            return object_state(reply)

    def set_pose(self, name: str, pose: Pose) -> None:
        """In the parent's frame. For motion use Session.push_object_pose(), which goes on between two pushes."""
        call(_lib.haptic_object_set_pose, self._handle, arrays.text(name), ctypes.byref(_raw_pose(pose)))

    def set_material(self, name: str, material: Material) -> None:
        """How hard it is, how it damps and rubs."""
        call(_lib.haptic_object_set_material, self._handle, arrays.text(name), ctypes.byref(raw_material(material)))

    def set_flags(self, name: str, flags: ObjectFlag) -> None:
        """All of them as they shall be, but for KEEP: that stays as when it was made."""
        call(_lib.haptic_object_set_flags, self._handle, arrays.text(name), arrays.whole(flags, 32, "flags"))

    def set_shape(self, name: str, shape: ShapeKind, size: Size = (), mesh: int = 0) -> None:
        """Another shape or mesh in the place of the one it has."""
        call(_lib.haptic_object_set_shape, self._handle, arrays.text(name), ctypes.byref(_raw_shape(shape, size, mesh)))

    def upload(self, vertices: npt.ArrayLike, triangles: npt.ArrayLike, *, deformable: bool = False, weld_m: float = 0.0,
               voxel_m: float = 0.0, point_spacing_m: float = 0.0, fill_holes: bool = False,
               progress: Optional[Callable[[float, str], Any]] = None) -> MeshReport:
        """Builds a mesh: n x 3 metres, m x 3 indices, counter-clockwise seen from outside.

        `weld_m` joins vertices that are no farther apart. `voxel_m` asks for the solid as a volume too, with a surface
        point each `point_spacing_m` (0: a voxel); the mesh must be closed then, or have its holes filled.
        `progress(fraction, stage)`, which may hear the same again, may return False to cancel; an exception in it, or of a signal's handler meanwhile,
        cancels and is raised here.
        """
        points, corners = arrays.points(vertices, "vertices"), arrays.corners(triangles, "triangles")
        raised: _List[BaseException] = []

        def report(fraction: float, stage: bytes, _: Any) -> int:
            if raised or progress is None:
                return 1 if raised else 0
            try:
                return 1 if progress(fraction, stage.decode()) is False else 0
            except BaseException as error:  # pylint: disable=broad-except
                raised.append(error)
                return 1

        volume = voxel_m != 0 or point_spacing_m != 0 or fill_holes
        upload = ctypes.c_void_p()
        call(_lib.haptic_upload_begin, self._handle, len(points), len(corners),
             (2 if deformable else 0) | (4 if volume else 0) | (8 if fill_holes else 0), ctypes.byref(upload))
        built = ctypes.c_void_p()  # The report, though a signal's handler raises before it is read.
        try:
            try:
                ctypes.memmove(_lib.haptic_upload_vertices(upload), points.ctypes.data, points.nbytes)
                ctypes.memmove(_lib.haptic_upload_triangles(upload), corners.ctypes.data, corners.nbytes)
                call(_lib.haptic_upload_weld, upload, weld_m)
                if volume:
                    call(_lib.haptic_upload_volume, upload, voxel_m, point_spacing_m)
                with _hearing(report, raised):
                    call(_lib.haptic_upload_commit, upload, _abi.Progress(report), None, 0, ctypes.byref(built))
            except HapticError:
                if raised:
                    raise raised[0] from None
                raise
            finally:
                _lib.haptic_upload_close(upload)
            if raised:
                raise raised[0]
            return mesh_report(_abi.MeshReport.from_address(built.value))
        except BaseException:
            if built.value is not None:  # Nobody will hear its number.
                with contextlib.suppress(HapticError):
                    self.drop_mesh(_abi.MeshReport.from_address(built.value).id)
            raise
        finally:
            _lib.haptic_free(built)

    def meshes(self) -> _List[MeshReport]:
        """All meshes, whoever uploaded them."""
        with _Reply(_abi.MeshList, _lib.haptic_mesh_list_all, self._handle) as reply:
            return [mesh_report(entry) for entry in _entries(reply)]

    def volume_file(self, name: str) -> int:
        """The volume of an object's mesh as an OpenVDB file: a descriptor to read, which the caller closes."""
        descriptor = ctypes.c_int(-1)
        call(_lib.haptic_object_volume_file, self._handle, arrays.text(name), ctypes.byref(descriptor))
        return descriptor.value

    def drop_mesh(self, mesh: int) -> None:
        """Gives a mesh back, by its number; refused while an object shows it."""
        call(_lib.haptic_mesh_drop, self._handle, arrays.whole(mesh, 64, "mesh"))

    def set_surface(self, name: str, surface: Surface) -> None:
        """All of it at once; dataclasses.replace() changes a part."""
        call(_lib.haptic_object_set_surface, self._handle, arrays.text(name),
             ctypes.byref(_abi.Surface(**dataclasses.asdict(surface))))

    def set_effect(self, name: str, kind: EffectKind, *, force: float = 1.0, stiffness: float = 200.0,
                   damping: float = 2.0, reach: float = 0.02, hz: float = 100.0, duration_s: float = 0.0,
                   path: Optional[npt.ArrayLike] = None) -> None:
        """What the object does to a hand in free space; all of it at once, and what is not named is as here.

        force: the most it pushes [N]; stiffness of a guide and of friction that sticks [N/m]; damping of viscous and of a
        guide across its way [N s/m]; reach, beyond which there is nothing [m]; hz of a vibration; it ends duration_s after
        it was set, 0 for never. path: n x 3 metres in the object's frame, a smooth curve in place of the object itself.
        """
        points = None if path is None else np.ascontiguousarray(arrays.points(path, "path"), dtype=np.float64)
        raw = _abi.Effect(kind=int(EffectKind(kind)), force=force, stiffness=stiffness, damping=damping, reach=reach,
                          hz=hz, duration_s=duration_s, path=None if points is None else points.ctypes.data,
                          path_count=0 if points is None else len(points))
        call(_lib.haptic_object_set_effect, self._handle, arrays.text(name), ctypes.byref(raw))

    def upload_relief(self, grey: npt.ArrayLike) -> TextureReport:
        """A picture as rows from the upper edge: 1 is the surface itself, 0 the deepest; uint8 and uint16 as they are."""
        pixels = arrays.pixels(grey, "grey")
        with _Reply(_abi.TextureReport, _lib.haptic_upload_relief, self._handle, pixels.ctypes.data,
                    pixels.shape[1], pixels.shape[0]) as reply:
            return texture_report(reply)

    def upload_vibration(self, rate_hz: float, models: Sequence[VibrationModel],
                         triangles: npt.ArrayLike) -> TextureReport:
        """Models at `rate_hz` and the triangles between them, three indices each, from 0."""
        orders = {len(model.a) for model in models}
        if len(orders) != 1:
            raise ValueError("models: all need as many coefficients")
        order = orders.pop()
        coefficients = [(ctypes.c_double * order)(*model.a) for model in models]
        raw = (_abi.VibrationModel * len(models))()
        for entry, model, a in zip(raw, models, coefficients):
            entry.speed, entry.force, entry.variance = model.speed, model.force, model.variance
            entry.a = ctypes.addressof(a)
        corners = arrays.corners(triangles, "triangles")
        vibration = _abi.Vibration(order=order, rate_hz=rate_hz, model_count=len(models), triangle_count=len(corners),
                                   models=raw, triangles=corners.ctypes.data)
        with _Reply(_abi.TextureReport, _lib.haptic_upload_vibration, self._handle,
                    ctypes.byref(vibration)) as reply:
            return texture_report(reply)

    def textures(self) -> _List[TextureReport]:
        """All textures, whoever uploaded them."""
        with _Reply(_abi.TextureList, _lib.haptic_texture_list_all, self._handle) as reply:
            return [texture_report(entry) for entry in _entries(reply)]

    def drop_texture(self, texture: int) -> None:
        """Gives a texture back, by its number; refused while a surface has it."""
        call(_lib.haptic_texture_drop, self._handle, arrays.whole(texture, 64, "texture"))


class Client(Handle):
    """A connection to the daemon; use it as a context manager.

    Without `socket`: $HAPTICD_SOCKET, else the first that answers of $XDG_RUNTIME_DIR/hapticd and /run/hapticd; an
    empty one is refused. Calls wait `timeout_s` for an answer; 0: 5 s. When it is closed, sessions and subscriptions made
    here are dead; closing them later is fine.
    """
    _kind = "client"
    _release = _lib.haptic_disconnect

    def __init__(self, socket: Union[str, os.PathLike[str], None] = None, *, name: str = "python",
                 administration: bool = False, timeout_s: float = 0.0) -> None:
        path = None if socket is None else os.fspath(socket)
        options = _abi.ConnectOptions(flags=1 if administration else 0, socket=_bytes(path), name=arrays.text(name),
                                      timeout_ns=round(min(timeout_s, 1e9) * 1e9))
        handle = ctypes.c_void_p()
        call(_lib.haptic_connect, ctypes.byref(options), ctypes.byref(handle))
        super().__init__(handle)

    @property
    def connected(self) -> bool:
        """Whether the connection stands."""
        return _lib.haptic_connected(self._open) != 0

    def reconnect(self) -> None:
        """Connects again; sessions come back by Session.reopen(), subscriptions by themselves, or this raises."""
        call(_lib.haptic_reconnect, self._handle)

    def info(self) -> DaemonInfo:
        """Version, process and scheduling of the daemon."""
        with _Reply(_abi.DaemonInfo, _lib.haptic_get_daemon_info, self._handle) as reply:
            return plain(DaemonInfo, reply)

    def devices(self) -> list[DeviceInfo]:
        """Open devices first, then those found, then those that are configured and missing (`problem`)."""
        with _Reply(_abi.DeviceList, _lib.haptic_device_list_all, self._handle) as reply:
            return [device_info(entry) for entry in _entries(reply)]

    def open_device(self, uri: str = "") -> DeviceInfo:
        """By URI, name or serial; without one the first open device, else the first real one, else the simulator."""
        with _Reply(_abi.DeviceInfo, _lib.haptic_device_open, self._handle, arrays.device(uri)) as reply:
            return device_info(reply)

    def close_device(self, uri: str) -> None:
        """Administration; but a simulated device that only this client has asked for, never an administrator, and that is
        not configured may go. Waits until its force is lowered."""
        call(_lib.haptic_device_close, self._handle, arrays.device(uri))

    def stop(self, uri: str = "") -> None:
        """Zero force at once; without a URI on every device."""
        call(_lib.haptic_stop, self._handle, arrays.device(uri))

    def set_limits(self, uri: str = "", **limits: float) -> DeviceLimits:
        """set_limits(uri, force=2.0): what is not named stays. Gives the limits in force; asks for them if none is named."""
        raw = _abi.DeviceLimits(**{name: math.nan for name, kind in _abi.DeviceLimits._fields_
                                   if kind is ctypes.c_double})
        for name, value in limits.items():
            if name not in DeviceLimits.__dataclass_fields__:
                raise TypeError(f"no limit is called {name}")
            setattr(raw, name, value)
        in_force = _abi.DeviceLimits()
        call(_lib.haptic_device_set_limits, self._handle, arrays.device(uri), ctypes.byref(raw), ctypes.byref(in_force))
        return plain(DeviceLimits, in_force)

    def status(self) -> Status:
        """Devices and clients as they are now."""
        with _Reply(_abi.Status, _lib.haptic_get_status, self._handle) as reply:
            return status(reply)

    def statistics(self, uri: str = "", reset: bool = False) -> Statistics:
        """Counters and histograms of a device. To reset the histograms takes administration."""
        with _Reply(_abi.Statistics, _lib.haptic_get_statistics, self._handle, arrays.device(uri), int(reset)) as reply:
            return plain(Statistics, reply, histograms=[plain(Histogram, reply.histograms[i].contents)
                                                        for i in range(reply.histogram_count)])

    def doctor(self) -> list[Check]:
        """What the daemon finds about itself, with the remedy of each fault."""
        with _Reply(_abi.CheckList, _lib.haptic_run_doctor, self._handle) as reply:
            return [plain(Check, entry) for entry in _entries(reply)]

    def _text(self, function: Any, *arguments: Any) -> str:
        with _Reply(_abi.Text, function, self._handle, *arguments) as reply:
            return ctypes.string_at(reply.text, reply.length).decode()

    def get(self, path: str) -> Any:
        """A resource, /objects/C/pos, as Python values."""
        return json.loads(self._text(_lib.haptic_get, arrays.text(path)))

    def set(self, uri: str) -> Any:
        """/objects/C/pos?value=1,2,3; gives the value now in force."""
        return json.loads(self._text(_lib.haptic_set, arrays.text(uri)))

    def configuration(self) -> str:
        """TOML."""
        return self._text(_lib.haptic_get_configuration)

    def dump(self) -> Any:
        """All there is to know, for a bug report."""
        return json.loads(self._text(_lib.haptic_get_dump))

    def open_session(self, uri: str = "", name: Optional[str] = None) -> Session:
        """Opens the device if need be: by URI, name or serial, without one as open_device()."""
        options = _abi.SessionOptions(uri=arrays.device(uri), name=_bytes(name))
        handle = ctypes.c_void_p()
        call(_lib.haptic_session_open, self._handle, ctypes.byref(options), ctypes.byref(handle))
        return Session(handle, self)

    @property
    def scene(self) -> Scene:
        """Named objects and meshes, shared by all clients."""
        return Scene(self)

    def record(self, uri: str = "") -> Recording:
        """Begins to record a device, which must not be armed. Read the stream until its end."""
        return Recording(self, uri)

    def subscribe(self, *kinds: int, capacity: int = 0) -> Events:
        """Events of these EventKinds; none named: all."""
        options = _abi.EventsOptions(kinds=sum(1 << int(kind) for kind in set(kinds)), capacity=capacity)
        handle = ctypes.c_void_p()
        call(_lib.haptic_events_open, self._handle, ctypes.byref(options), ctypes.byref(handle))
        return Events(handle, self)


class Frame(_Chosen):
    """Axes of other systems; frames.h has the table."""
    HAPTICD = 0
    OPENGL = 1
    ROS = 2
    HAPLY = 3


def convert(values: npt.ArrayLike, source: Frame, target: Frame) -> npt.NDArray[np.float64]:
    """Exact: 3 numbers are a vector, 4 a quaternion w, x, y, z, 3 x 3 a matrix."""
    given = np.ascontiguousarray(np.asarray(values, np.float64))
    functions = {(3,): _lib.haptic_convert_vector, (4,): _lib.haptic_convert_quaternion,
                 (3, 3): _lib.haptic_convert_matrix}
    if given.shape not in functions:
        raise ValueError("3 numbers, 4 numbers or 3 x 3 numbers are needed")
    result = np.empty_like(given)
    check(functions[given.shape](Frame(source), Frame(target), given.ctypes.data, result.ctypes.data))
    return result
