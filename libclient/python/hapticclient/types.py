"""What the library tells, as plain Python values. Units and meaning: the C headers of the same names."""
from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import NamedTuple

from . import _abi

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class Pose(NamedTuple):
    """Place [m] and orientation (unit quaternion w, x, y, z)."""
    p: Vector = (0.0, 0.0, 0.0)
    q: Quaternion = (1.0, 0.0, 0.0, 0.0)


class Material(NamedTuple):
    """What a surface feels like: N/m, N s/m, mu_s, mu_d."""
    stiffness: float = 1000.0
    damping: float = 1.0
    friction_static: float = 0.0
    friction_dynamic: float = 0.0


@dataclass(frozen=True)
class Surface:
    """What a surface feels like beyond its material. A plain one by default; what is turned on is moderate.

    smooth_deg: edges that bend less are shaded round, 0 for none. transient_gain: force per speed of impact [N s/m], which
    rings at transient_hz and decays to 1/e in transient_decay_s. relief: a texture's id, 0 for none; relief_depth from white
    down to black, relief_width and _height of the picture [m]. vibration: a texture's id; vibration_mass: force per
    recorded acceleration [kg].
    """
    smooth_deg: float = 0.0
    transient_gain: float = 0.0
    transient_hz: float = 150.0
    transient_decay_s: float = 0.01
    relief: int = 0
    relief_depth: float = 0.0002
    relief_width: float = 0.1
    relief_height: float = 0.1
    vibration: int = 0
    vibration_mass: float = 0.05


@dataclass(frozen=True)
class VibrationModel:
    """Acceleration at one speed [m/s] and force [N]: y[n] = e[n] - a[0] y[n-1] - ..., e of that variance."""
    speed: float
    force: float
    variance: float
    a: tuple[float, ...]


class _Chosen(enum.IntEnum):
    """A kind that a program chooses: what is none is told those that are."""

    @classmethod
    def _missing_(cls, value: object) -> None:
        raise ValueError(f"{value!r} is none of {', '.join(f'{cls.__name__}.{kind.name}' for kind in cls)}")


class EffectKind(_Chosen):
    """What an object does to a hand in free space (docs/effects.md); z is the object's own.

    FORCE: a push along z. VISCOUS: drag. FRICTION: sticks, then slides. VIBRATION: swings along z. GUIDE: draws to the path,
    the shape or the origin.
    """
    NONE = 0
    FORCE = 1
    VISCOUS = 2
    FRICTION = 3
    VIBRATION = 4
    GUIDE = 5


class ShapeKind(_Chosen):
    """What an object is, and the `size` that goes with it, in metres.

    GROUP: nothing to touch, a parent for others. PLANE: solid below z = 0. SPHERE: radius. BOX: half-extents x, y, z.
    CAPSULE: radius, half-length along z without the caps. CYLINDER: radius, half-length along z. MESH: an upload's `mesh`.
    """
    GROUP = 0
    PLANE = 1
    SPHERE = 2
    BOX = 3
    CAPSULE = 4
    CYLINDER = 5
    MESH = 6


class ObjectFlag(enum.IntFlag):
    """ENABLED: it can be touched. VISIBLE: for viewers. TWO_SIDED: both faces of an open mesh stop the proxy. KEEP: it stays
    when the client that made it leaves."""
    ENABLED = 1
    VISIBLE = 2
    TWO_SIDED = 4
    KEEP = 256


class Ability(enum.IntFlag):
    """What a device senses, actuates and has: bits of DeviceInfo.abilities."""
    SENSES_POSITION = 1
    SENSES_ROTATION = 2
    SENSES_GRIPPER = 4
    ACTUATES_POSITION = 8
    ACTUATES_ROTATION = 16
    ACTUATES_GRIPPER = 32
    LEFT_HAND = 64
    RIGHT_HAND = 128
    HAS_BRAKES = 256
    HAS_WATCHDOG = 512
    HAS_DEADMAN = 1024
    HAS_VELOCITY_LIMIT = 2048


class Calibration(enum.IntEnum):
    """DeviceInfo.calibration."""
    NOT_NEEDED = 0
    NEEDED = 1
    RUNNING = 2
    DONE = 3


class Source(enum.IntEnum):
    """Whose force it is: the rows of a sample's by_source."""
    SURFACE = 0
    EFFECT = 1
    LOCAL_MODEL = 2
    CLIENT = 3
    GRAVITY = 4
    TEXTURE = 5
    TRANSIENT = 6
    GUARD = 7


class Fault(enum.IntEnum):
    """Why the guard latched: `fault` of a sample and of DeviceStatus, `value` of a fault's event."""
    NONE = 0
    STOP_LINE = 1
    NOT_FINITE = 2
    VELOCITY = 3
    DEVICE_LOST = 4
    DEVICE_ERROR = 5
    DEADMAN = 6
    OVERRUN = 7
    ENERGY = 8


class SampleFlag(enum.IntFlag):
    """Bits of a sample's `flags`.

    ARMED: forces reach the device. RAMPING: the arming ramp is below one. WAITING: armed, but the ramp waits until the force
    asked for is small. FAULT: one is latched, see `fault`. CONTACT: the proxy touches. SLIP: and slides. LIMITED: a limit
    reduced the force. SATURATED: the device's own did. PASSIVITY: the guard added damping. STALE: no new reading of the
    device. NO_RT: no real-time scheduling. CLUTCHED: the hand moves free of its point in the world, which stands still.
    """
    ARMED = 1
    RAMPING = 2
    FAULT = 4
    CONTACT = 8
    SLIP = 16
    LIMITED = 32
    PASSIVITY = 64
    STALE = 128
    NO_RT = 256
    SATURATED = 512
    WAITING = 1024
    CLUTCHED = 2048


class EventKind(enum.IntEnum):
    """What an event tells, with Event.object for TOUCH and UNTOUCH. Event.value is of BUTTON the mask now, of FAULT the Fault,
    of OVERRUN the periods missed since the last, of MODEL_EXPIRED the slot (eight a second of a session;
    Event.text tells how many were left out), of REFUSED the Code of a push that the daemon has refused, with what and why in
    Event.text."""
    TOUCH = 0
    UNTOUCH = 1
    BUTTON = 2
    FAULT = 3
    ARMED = 4
    DISARMED = 5
    LEASE_LOST = 6
    LEASE_TAKEN = 7
    DEVICE_ADDED = 8
    DEVICE_REMOVED = 9
    OVERRUN = 10
    CLIENT_JOINED = 11
    CLIENT_LEFT = 12
    MODEL_EXPIRED = 13
    OBJECT_CHANGED = 14
    REFUSED = 15


@dataclass(frozen=True)
class DaemonInfo:
    """What the daemon said of itself. Another `epoch` is a restarted daemon; `scheduling_note` says why it is not `realtime`."""
    pid: int
    protocol_major: int
    protocol_minor: int
    epoch: int
    administration: bool
    realtime: bool
    started_ns: int
    version: str
    scheduling_note: str
    socket: str
    config_file: str


@dataclass(frozen=True)
class DeviceInfo:
    """The data sheet of a device, in m, N, N m, N/m, N s/m, rad and kg; 0 where unknown, NaN for the temperature.

    Of the device, not of the world: without its mount and scale (docs/mount.md).
    `uri` opens this device and no other. `workspace_lower` and `_upper` are the usable box, max_workspace_ the reachable one.
    `problem`: why it is not open although the daemon was told to open it.
    """
    open: bool
    abilities: Ability
    buttons: int
    calibration: int
    uri: str
    name: str
    model: str
    manufacturer: str
    serial: str
    firmware: str
    driver: str
    driver_version: str
    calibration_style: str
    max_force: float
    continuous_force: float
    max_torque: float
    max_gripper_force: float
    max_stiffness: float
    max_angular_stiffness: float
    max_gripper_stiffness: float
    max_damping: float
    max_angular_damping: float
    workspace_radius: float
    workspace_lower: Vector
    workspace_upper: Vector
    max_workspace_lower: Vector
    max_workspace_upper: Vector
    gripper_max_angle: float
    position_resolution: float
    rotation_resolution: float
    force_resolution: float
    native_rate_hz: float
    apparent_mass: float
    viscous_friction: float
    coulomb_friction: float
    max_velocity: float
    temperature_c: float
    problem: str


@dataclass(frozen=True)
class DeviceLimits:
    """What binds the sum of all clients: N, N m, N/s, N m/s, m/s (beyond it the guard latches), W, W of active sources, N.

    Of the device, not of the world, as DeviceInfo.
    """
    force: float
    torque: float
    force_slew: float
    torque_slew: float
    velocity: float
    power: float
    active_power: float
    gripper_force: float


@dataclass(frozen=True)
class DeviceStatus:
    """A device now. `busy`: the median part of a period that the cycle takes; `cycles`, `missed` and `stale` are its servo's."""
    armed: bool
    fault: int
    lease_pid: int
    uri: str
    name: str
    fault_text: str
    lease_holder: str
    group: str
    scheduling: str
    rate_hz: float
    busy: float
    cycles: int
    missed: int
    stale: int
    wake_p99_ns: int
    limits: DeviceLimits
    pose: Pose
    force: Vector


@dataclass(frozen=True)
class ClientStatus:
    """A client's session now: commands `received` and `rejected`, local `models` in force, `fade` 1 while it is alive."""
    pid: int
    uid: int
    lease: bool
    session: int
    name: str
    device: str
    received: int
    rejected: int
    stale: int
    models: int
    fade: float
    heartbeat_age_ns: int
    bytes: int


@dataclass(frozen=True)
class Status:
    """Devices and clients on one page."""
    objects: int
    triangles: int
    locked_bytes: int
    uptime_ns: int
    info: DaemonInfo
    devices: list[DeviceStatus]
    clients: list[ClientStatus]


@dataclass(frozen=True)
class Histogram:
    """A distribution of times: its count, quantiles and maximum [ns]."""
    name: str
    count: int
    p50_ns: int
    p99_ns: int
    p999_ns: int
    p9999_ns: int
    max_ns: int


@dataclass(frozen=True)
class Statistics:
    """Counters of a device's servo since its start, and histograms since then or since they were reset."""
    uri: str
    period_ns: int
    cycles: int
    missed: int
    overruns: int
    stale_samples: int
    histograms: list[Histogram]
    collide_queries: int
    """Answers of the collide thread on held tools and free objects."""
    collide_exhausted: int
    """Of them, those whose time or work was not enough: contacts may be missing."""
    collide_unsent: int
    """Of them, those that the servo had no room for: it stands or is late."""


@dataclass(frozen=True)
class Check:
    """One finding of the doctor; when red, `remedy` is the line that mends it."""
    state: int
    """0 green, 1 red, 2 not applicable."""
    name: str
    detail: str
    remedy: str


@dataclass(frozen=True)
class ObjectState:
    """An object as it stands. `id` is for pushes; `pose` is in the parent's frame; `shape` is a ShapeKind, of a newer daemon
    maybe a number that is none yet; `size` as ShapeKind tells."""
    id: int
    triangles: int
    path: str
    owner: str
    world_pose: Pose
    name: str
    parent: str
    flags: ObjectFlag
    pose: Pose
    shape: int
    size: Vector
    mesh: int
    material: Material
    surface: Surface


@dataclass(frozen=True)
class MeshReport:
    """What the builder made of a mesh. `id` is for Scene.create(mesh=...); `closed`: it has an inside; box in metres; `notes`:
    repairs, each naming its triangle."""
    closed: bool
    id: int
    vertices: int
    triangles: int
    bytes: int
    lower: Vector
    upper: Vector
    build_ns: int
    notes: list[str]


@dataclass(frozen=True)
class TextureReport:
    """A texture that the daemon holds. `id` is for Surface.relief or .vibration; `uses`: surfaces that show it."""
    relief: bool
    id: int
    width: int
    height: int
    models: int
    uses: int
    rate_hz: float
    bytes: int
    owner: str


@dataclass(frozen=True)
class Event:
    """What happened: `t_ns` [CLOCK_MONOTONIC] and `tick` say when, `point` [m] where, `force` [N] what the surface
    asks for, of which a hand that is not armed feels none; `kind` is an EventKind (a newer daemon may send others); `lost` counts
    events that came too fast since the subscription began."""
    kind: int
    t_ns: int
    tick: int
    session: int
    lost: int
    value: int
    point: Vector
    force: float
    device: str
    object: str
    text: str

    @property
    def name(self) -> str:
        """"touch", "untouch", ..."""
        return _abi.lib.haptic_event_name(self.kind).decode()


@dataclass(frozen=True)
class SessionInfo:
    """A session: `device_index` is a sample's `device` for the one asked for, of `device_count` that share the servo."""
    device_index: int
    device_count: int
    id: int
    epoch: int
    period_ns: int
    device: DeviceInfo


@dataclass(frozen=True)
class Acks:
    """What became of a session's commands: the last one taken from the ring and the last one the servo has seen to, in force
    or refused; how many the daemon refused before the servo, and of the last of them the number and Code. `fade` is 1 while the session is alive; `ended`: the daemon has closed it."""
    ring_head: int
    violations: int
    received_seq: int
    rejected: int
    last_rejected_seq: int
    last_rejected_code: int
    stale_mailboxes: int
    applied_seq: int
    applied_tick: int
    heartbeat_age_ns: int
    fade: float
    ended: bool


@dataclass(frozen=True)
class ModelStatus:
    """Life of a model slot: the number of the push that set it, time since then, and `weight`, falling while it fades."""
    seq: int
    age_ns: int
    weight: float
    state: int
    """0 empty, 1 blending in, 2 in force, 3 expired and fading."""


@dataclass(frozen=True)
class Counters:
    """Of the servo since its start."""
    cycles: int
    missed: int
    overruns: int
    stale_samples: int
    contacts: int
    faults: int
    max_wake_ns: int
    max_cycle_ns: int
