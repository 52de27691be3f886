"""The C interface as ctypes sees it: structures, prototypes, the loaded library.

Private. Field names and order are those of the installed headers; tests/python compares them with a C compiler's.
"""
from __future__ import annotations

import ctypes as c
import operator
import os
from typing import Any

u8, u32, u64, i32, i64 = c.c_uint8, c.c_uint32, c.c_uint64, c.c_int32, c.c_int64
f32, f64, text = c.c_float, c.c_double, c.c_char_p
vec3 = f64 * 3


class Struct(c.Structure):
    """A structure whose `size`, if it has one, is set when it is made here. Numbers that do not fit are refused by name."""

    def __init__(self, **fields: Any) -> None:
        super().__init__()
        for name, value in fields.items():
            try:
                setattr(self, name, value)
            except TypeError as error:  # It does not say which.
                raise TypeError(f"{name}: {error}") from None
            # ctypes cuts off what is too long: slot 2^32 would be slot 0.
            if hasattr(value, "__index__") and operator.index(value) != (getattr(self, name) or 0):  # numpy's, too
                raise ValueError(f"{name}: {value} is out of range")
        if any(name == "size" and kind is u32 for name, kind in self._fields_):
            self.size = c.sizeof(self)


def struct(name: str, *fields: tuple[str, Any]) -> type[Struct]:
    return type(name, (Struct,), {"_fields_": list(fields)})


def many(kind: Any, names: str) -> list[tuple[str, Any]]:
    return [(name, kind) for name in names.split()]


def pointers(kind: Any) -> Any:
    """const kind* const*"""
    return c.POINTER(c.POINTER(kind))


Error = struct("haptic_error", ("size", u32), ("code", i32), ("where", c.c_char * 256), ("what", c.c_char * 512),
               ("remedy", c.c_char * 512))
Text = struct("haptic_text", ("size", u32), ("reserved", u32), ("length", u64), ("text", c.POINTER(c.c_char)))
Pose = struct("haptic_pose", ("p", vec3), ("q", f64 * 4))
Material = struct("haptic_material", *many(f64, "stiffness damping friction_static friction_dynamic"))

ConnectOptions = struct("haptic_connect_options", ("size", u32), ("flags", u32), ("socket", text), ("name", text),
                        ("timeout_ns", i64))
DaemonInfo = struct("haptic_daemon_info", ("size", u32), ("pid", i32), ("protocol_major", u32),
                    ("protocol_minor", u32), ("epoch", u64), ("administration", u32), ("realtime", u32),
                    ("started_ns", i64), *many(text, "version scheduling_note socket config_file"))
DeviceInfo = struct(
    "haptic_device_info", *many(u32, "size open abilities buttons calibration reserved"),
    *many(text, "uri name model manufacturer serial firmware driver driver_version calibration_style"),
    *many(f64, "max_force continuous_force max_torque max_gripper_force max_stiffness max_angular_stiffness "
               "max_gripper_stiffness max_damping max_angular_damping workspace_radius"),
    *many(vec3, "workspace_lower workspace_upper max_workspace_lower max_workspace_upper"),
    *many(f64, "gripper_max_angle position_resolution rotation_resolution force_resolution native_rate_hz "
               "apparent_mass viscous_friction coulomb_friction max_velocity temperature_c"), ("problem", text))
DeviceList = struct("haptic_device_list", ("size", u32), ("count", u32), ("items", pointers(DeviceInfo)))
DeviceLimits = struct("haptic_device_limits", ("size", u32), ("reserved", u32),
                      *many(f64, "force torque force_slew torque_slew velocity power active_power gripper_force"))
DeviceStatus = struct(
    "haptic_device_status", ("size", u32), ("armed", u32), ("fault", u32), ("lease_pid", i32),
    *many(text, "uri name fault_text lease_holder group scheduling"), ("rate_hz", f64), ("busy", f64),
    *many(u64, "cycles missed stale"), ("wake_p99_ns", u32), ("reserved", u32), ("limits", c.POINTER(DeviceLimits)),
    ("pose", Pose), ("force", vec3))
ClientStatus = struct(
    "haptic_client_status", ("size", u32), ("pid", i32), ("uid", u32), ("lease", u32), ("session", u64),
    ("name", text), ("device", text), *many(u64, "received rejected stale"), ("models", u32), ("fade", f32),
    ("heartbeat_age_ns", i64), ("bytes", u64))
Status = struct("haptic_status", *many(u32, "size device_count client_count objects"), ("triangles", u64),
                ("locked_bytes", u64), ("uptime_ns", i64), ("info", c.POINTER(DaemonInfo)),
                ("devices", pointers(DeviceStatus)), ("clients", pointers(ClientStatus)))
Histogram = struct("haptic_histogram", ("size", u32), ("reserved", u32), ("name", text),
                   *many(u64, "count p50_ns p99_ns p999_ns p9999_ns max_ns"))
Statistics = struct("haptic_statistics", ("size", u32), ("histogram_count", u32), ("uri", text), ("period_ns", i64),
                    *many(u64, "cycles missed overruns stale_samples"), ("histograms", pointers(Histogram)),
                    *many(u64, "collide_queries collide_exhausted collide_unsent"))
Check = struct("haptic_check", ("size", u32), ("state", u32), *many(text, "name detail remedy"))
CheckList = struct("haptic_check_list", ("size", u32), ("count", u32), ("items", pointers(Check)))

RecordingEnd = struct("haptic_recording_end", ("size", u32), ("reserved", u32), ("cycles", u64), ("lost", u64),
                      ("reason", text))

Shape = struct("haptic_shape", ("kind", u32), ("reserved", u32), ("size", vec3), ("mesh", u64))
Object = struct("haptic_object", ("size", u32), ("flags", u32), ("name", text), ("parent", text), ("pose", Pose),
                ("shape", Shape), ("material", Material))
Surface = struct("haptic_surface", ("size", u32), ("reserved", u32),
                 *many(f64, "smooth_deg transient_gain transient_hz transient_decay_s"), ("relief", u64),
                 *many(f64, "relief_depth relief_width relief_height"), ("vibration", u64), ("vibration_mass", f64))
Effect = struct("haptic_effect", ("size", u32), ("kind", u32),
                *many(f64, "force stiffness damping reach hz duration_s"), ("path", c.c_void_p), ("path_count", u32),
                ("reserved", u32))
TextureReport = struct("haptic_texture_report", ("size", u32), ("relief", u32), ("id", u64),
                       *many(u32, "width height models uses"), ("rate_hz", f64), ("bytes", u64), ("owner", text))
TextureList = struct("haptic_texture_list", ("size", u32), ("count", u32), ("items", pointers(TextureReport)))
VibrationModel = struct("haptic_vibration_model", *many(f64, "speed force variance"), ("a", c.c_void_p))
Vibration = struct("haptic_vibration", ("size", u32), ("order", u32), ("rate_hz", f64), ("model_count", u32),
                   ("triangle_count", u32), ("models", c.POINTER(VibrationModel)), ("triangles", c.c_void_p))
ObjectState = struct("haptic_object_state", *many(u32, "size id triangles reserved"), ("path", text), ("owner", text),
                     ("world_pose", Pose), ("object", c.POINTER(Object)), ("surface", c.POINTER(Surface)))
ObjectList = struct("haptic_object_list", ("size", u32), ("count", u32), ("items", pointers(ObjectState)))
MeshReport = struct("haptic_mesh_report", ("size", u32), ("closed", u32), ("id", u64), ("vertices", u32),
                    ("triangles", u32), ("bytes", u64), ("lower", vec3), ("upper", vec3), ("build_ns", i64),
                    ("note_count", u32), ("reserved", u32), ("notes", c.POINTER(text)))
MeshList = struct("haptic_mesh_list", ("size", u32), ("count", u32), ("items", pointers(MeshReport)))
Progress = c.CFUNCTYPE(c.c_int, f32, text, c.c_void_p)

Event = struct("haptic_event", ("size", u32), ("kind", u32), ("t_ns", i64), *many(u64, "tick session lost"),
               ("value", u32), ("reserved", u32), ("point", vec3), ("force", f64), ("device", c.c_char * 64),
               ("object", c.c_char * 64), ("text", c.c_char * 256))
EventsOptions = struct("haptic_events_options", *many(u32, "size kinds capacity reserved"), ("callback", c.c_void_p),
                       ("user", c.c_void_p))

SessionOptions = struct("haptic_session_options", ("size", u32), ("flags", u32), ("uri", text), ("name", text))
SessionInfo = struct("haptic_session_info", *many(u32, "size device_index device_count reserved"), ("id", u64),
                     ("epoch", u64), ("period_ns", i64), ("device", c.POINTER(DeviceInfo)))
Acks = struct("haptic_acks", ("ring_head", u32), ("violations", u32),
              *many(u64, "received_seq rejected last_rejected_seq"), ("last_rejected_code", u32),
              ("stale_mailboxes", u32), ("applied_seq", u64), ("applied_tick", u64), ("heartbeat_age_ns", i64),
              ("fade", f32), ("ended", u32))
ModelStatus = struct("haptic_model_status", ("seq", u64), ("age_ns", i64), ("weight", f32), ("state", u32))
Counters = struct("haptic_counters", *many(u64, "cycles missed overruns stale_samples contacts faults"),
                  ("max_wake_ns", u32), ("max_cycle_ns", u32))

Push = struct("haptic_push", ("at_tick", u64), ("flags", u32), ("reserved", u32), ("seq", u64))
ObjectPose = struct("haptic_object_pose", ("object", u32), ("lease_us", u32), ("p", vec3), ("q", f64 * 4),
                    ("v", vec3), ("w", vec3))
ObjectMaterial = struct("haptic_object_material", ("object", u32), ("reserved", u32), ("material", Material))
ObjectFlags = struct("haptic_object_flags", *many(u32, "object mask value reserved"))
VertexMove = struct("haptic_vertex_move", ("index", u32), ("p", f32 * 3))
ObjectVertices = struct("haptic_object_vertices", ("object", u32), ("count", u32), ("move", VertexMove * 26))
LocalModel = struct("haptic_local_model", *many(u32, "slot kind frame device"), ("lease_ns", i64), ("blend_ns", i64),
                    ("material", Material), ("origin", vec3), ("normal", vec3), ("radius", f64), ("count", u32),
                    ("reserved", u32), ("halfspace", (f32 * 4) * 16))
ForceField = struct("haptic_force_field", *many(u32, "slot frame device reserved"), ("lease_ns", i64),
                    ("blend_ns", i64), ("x0", vec3), ("f0", vec3), ("jacobian", f64 * 9), ("radius", f64))
ClearModel = struct("haptic_clear_model", ("slot", u32), ("reserved", u32), ("blend_ns", i64))
ClientForce = struct("haptic_client_force", ("device", u32), ("reserved", u32), ("lease_ns", i64), ("force", vec3),
                     ("torque", vec3))
Intent = struct("haptic_intent", ("device", u32), ("reserved", u32), ("p", vec3), ("q", f64 * 4),
                ("gripper_rad", f64))
SessionLimits = struct("haptic_session_limits", ("force_n", f64), ("torque_nm", f64))

#: Offsets of haptic_sample, for numpy.
SAMPLE_FIELDS: list[tuple[Any, ...]] = [
    ("guard", "u8"), ("tick", "u8"), ("t_ns", "i8"), ("device", "u4"), ("flags", "u4"), ("fault", "u4"),
    ("buttons", "u4"), ("p", "f8", 3), ("q", "f8", 4), ("v", "f8", 3), ("w", "f8", 3), ("proxy", "f8", 3),
    ("force", "f8", 3), ("torque", "f8", 3), ("by_source", "f4", (8, 3)), ("gripper_rad", "f8"),
    ("gripper_force_n", "f8"), ("own", "f4", 3), ("energy_j", "f4"), ("depth_m", "f4"), ("contact_object", "u4"),
    ("missed", "u4"), ("wake_ns", "u4"), ("cycle_ns", "u4"), ("applied_commands", "u4"), ("reserved", "u1", 16)]

_Handle = c.c_void_p
_Out = c.POINTER(c.c_void_p)
_E = c.POINTER(Error)
_PROTOTYPES: dict[str, tuple[Any, list[Any]]] = {
    "error_name": (text, [c.c_int]),
    "error_text": (text, [c.c_int]),
    "version": (text, []),
    "free": (None, [c.c_void_p]),
    "now_ns": (i64, []),
    "convert_vector": (c.c_int, [c.c_uint32, c.c_uint32, c.c_void_p, c.c_void_p]),
    "convert_quaternion": (c.c_int, [c.c_uint32, c.c_uint32, c.c_void_p, c.c_void_p]),
    "convert_matrix": (c.c_int, [c.c_uint32, c.c_uint32, c.c_void_p, c.c_void_p]),
    "connect": (c.c_int, [c.POINTER(ConnectOptions), _Out, _E]),
    "disconnect": (None, [_Handle]),
    "connected": (c.c_int, [_Handle]),
    "reconnect": (c.c_int, [_Handle, _E]),
    "set_timeout": (c.c_int, [_Handle, i64]),
    "get_daemon_info": (c.c_int, [_Handle, _Out, _E]),
    "get": (c.c_int, [_Handle, text, _Out, _E]),
    "set": (c.c_int, [_Handle, text, _Out, _E]),
    "get_configuration": (c.c_int, [_Handle, _Out, _E]),
    "get_dump": (c.c_int, [_Handle, _Out, _E]),
    "device_list_all": (c.c_int, [_Handle, _Out, _E]),
    "device_open": (c.c_int, [_Handle, text, _Out, _E]),
    "device_close": (c.c_int, [_Handle, text, _E]),
    "stop": (c.c_int, [_Handle, text, _E]),
    "device_set_limits": (c.c_int, [_Handle, text, c.POINTER(DeviceLimits), c.POINTER(DeviceLimits), _E]),
    "get_status": (c.c_int, [_Handle, _Out, _E]),
    "get_statistics": (c.c_int, [_Handle, text, c.c_int, _Out, _E]),
    "run_doctor": (c.c_int, [_Handle, _Out, _E]),
    "session_open": (c.c_int, [_Handle, c.POINTER(SessionOptions), _Out, _E]),
    "session_close": (None, [_Handle]),
    "session_reopen": (c.c_int, [_Handle, _E]),
    "session_describe": (c.c_int, [_Handle, _Out, _E]),
    "session_acquire_lease": (c.c_int, [_Handle, _E]),
    "session_release_lease": (c.c_int, [_Handle, _E]),
    "session_arm": (c.c_int, [_Handle, _E]),
    "session_disarm": (c.c_int, [_Handle, _E]),
    "session_check": (c.c_int, [_Handle]),
    "session_latest_of": (c.c_int, [_Handle, u32, c.c_void_p]),
    "session_latest": (c.c_int, [_Handle, c.c_void_p]),
    "session_drain": (c.c_int, [_Handle, c.c_void_p, u32, c.POINTER(u32), c.POINTER(u64)]),
    "session_acks": (c.c_int, [_Handle, c.POINTER(Acks)]),
    "session_counters": (c.c_int, [_Handle, c.POINTER(Counters)]),
    "session_model_status": (c.c_int, [_Handle, u32, c.POINTER(ModelStatus)]),
    "push_object_pose": (c.c_int, [_Handle, c.POINTER(ObjectPose), c.POINTER(Push)]),
    "push_object_material": (c.c_int, [_Handle, c.POINTER(ObjectMaterial), c.POINTER(Push)]),
    "push_object_flags": (c.c_int, [_Handle, c.POINTER(ObjectFlags), c.POINTER(Push)]),
    "push_object_vertices": (c.c_int, [_Handle, c.POINTER(ObjectVertices), c.POINTER(Push)]),
    "push_local_model": (c.c_int, [_Handle, c.POINTER(LocalModel), c.POINTER(Push)]),
    "push_force_field": (c.c_int, [_Handle, c.POINTER(ForceField), c.POINTER(Push)]),
    "push_clear_model": (c.c_int, [_Handle, c.POINTER(ClearModel), c.POINTER(Push)]),
    "push_client_force": (c.c_int, [_Handle, c.POINTER(ClientForce), c.POINTER(Push)]),
    "push_intent": (c.c_int, [_Handle, c.POINTER(Intent), c.POINTER(Push)]),
    "push_limits": (c.c_int, [_Handle, c.POINTER(SessionLimits), c.POINTER(Push)]),
    "push_refusal": (c.c_int, [_Handle, _E]),
    "push_space": (u32, [_Handle]),
    "object_create": (c.c_int, [_Handle, c.POINTER(Object), c.POINTER(u32), _E]),
    "object_remove": (c.c_int, [_Handle, text, _E]),
    "object_list_all": (c.c_int, [_Handle, _Out, _E]),
    "object_find": (c.c_int, [_Handle, text, _Out, _E]),
    "object_set_pose": (c.c_int, [_Handle, text, c.POINTER(Pose), _E]),
    "object_set_material": (c.c_int, [_Handle, text, c.POINTER(Material), _E]),
    "object_set_flags": (c.c_int, [_Handle, text, u32, _E]),
    "object_set_shape": (c.c_int, [_Handle, text, c.POINTER(Shape), _E]),
    "upload_begin": (c.c_int, [_Handle, u32, u32, u32, _Out, _E]),
    "upload_vertices": (c.c_void_p, [_Handle]),
    "upload_triangles": (c.c_void_p, [_Handle]),
    "upload_weld": (c.c_int, [_Handle, f64, _E]),
    "upload_volume": (c.c_int, [_Handle, f64, f64, _E]),
    "upload_commit": (c.c_int, [_Handle, Progress, c.c_void_p, i64, _Out, _E]),
    "upload_close": (None, [_Handle]),
    "mesh_list_all": (c.c_int, [_Handle, _Out, _E]),
    "object_volume_file": (c.c_int, [_Handle, text, c.POINTER(c.c_int), _E]),
    "mesh_drop": (c.c_int, [_Handle, u64, _E]),
    "object_set_surface": (c.c_int, [_Handle, text, c.POINTER(Surface), _E]),
    "object_set_effect": (c.c_int, [_Handle, text, c.POINTER(Effect), _E]),
    "upload_relief": (c.c_int, [_Handle, c.c_void_p, u32, u32, _Out, _E]),
    "upload_vibration": (c.c_int, [_Handle, c.POINTER(Vibration), _Out, _E]),
    "texture_list_all": (c.c_int, [_Handle, _Out, _E]),
    "texture_drop": (c.c_int, [_Handle, u64, _E]),
    "event_name": (text, [u32]),
    "events_open": (c.c_int, [_Handle, c.POINTER(EventsOptions), _Out, _E]),
    "events_next": (c.c_int, [_Handle, c.POINTER(Event), i64]),
    "events_fd": (c.c_int, [_Handle]),
    "events_close": (None, [_Handle]),
    "recording_start": (c.c_int, [_Handle, text, _Out, _E]),
    "recording_fd": (c.c_int, [_Handle]),
    "recording_stop": (c.c_int, [_Handle, _Out, _E]),
    "recording_close": (None, [_Handle]),
}


def _load() -> c.CDLL:
    name = "libhapticclient.so.1"
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../..", name)  # under a prefix of its own
    path = os.environ.get("HAPTICCLIENT_LIBRARY") or (beside if os.path.exists(beside) else name)
    try:
        library = c.CDLL(path)
    except OSError as error:
        raise ImportError(f"{error} (apt install libhapticclient1, or name the library in HAPTICCLIENT_LIBRARY)",
                          path=path) from None
    for name, (result, arguments) in _PROTOTYPES.items():
        try:
            function = getattr(library, "haptic_" + name)
        except AttributeError:
            raise ImportError(f"{path}: it has no haptic_{name} (install a libhapticclient1 of this version)",
                              path=path) from None
        function.restype = result
        function.argtypes = arguments
    return library


lib = _load()
