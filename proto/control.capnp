@0xb6f3c2a9d1e84715;
# The control socket: configuration, never the servo's data. Rings and meshes travel in shared memory (shm_layout.h,
# snapshot.h); this schema hands out their descriptors.
#
# Every result starts with a Status; code 0 means done. Nothing else of an answer is set when the code is not 0.
# Vectors are SI in the world frame of docs/protocol.md; quaternions w, x, y, z.
# Evolution: add at the end with the next ordinal; never renumber, never retype.

using Cxx = import "/capnp/c++.capnp";
$Cxx.namespace("hapticd::proto");

const protocolMajor :UInt16 = 1;
const protocolMinor :UInt16 = 0;

struct Status {
  code @0 :UInt16;    # a number of errors.h
  where @1 :Text;     # the field, file, line, index or path at fault
  what @2 :Text;      # what is wrong with it
  remedy @3 :Text;    # what to do about it
}

struct Vec3 { x @0 :Float64; y @1 :Float64; z @2 :Float64; }
struct Quat { w @0 :Float64 = 1; x @1 :Float64; y @2 :Float64; z @3 :Float64; }
struct Pose { p @0 :Vec3; q @1 :Quat; }

struct Material {
  stiffness @0 :Float64;        # N/m
  damping @1 :Float64;          # N s/m
  frictionStatic @2 :Float64;
  frictionDynamic @3 :Float64;
}

struct Surface {                      # what a surface feels like beyond its material; docs/surfaces.md
  smoothDeg @0 :Float64;              # edges that bend less than this are shaded round; 0: none is
  transientGain @1 :Float64;          # N s/m: force per speed of impact; 0: none
  transientHz @2 :Float64 = 150;      # what an impact rings at
  transientDecay @3 :Float64 = 0.01;  # s, to 1/e
  relief @4 :UInt64;                  # texture, 0 for none
  reliefDepth @5 :Float64 = 0.0002;   # m, from white down to black
  reliefWidth @6 :Float64 = 0.1;      # m, of the picture
  reliefHeight @7 :Float64 = 0.1;
  vibration @8 :UInt64;               # texture, 0 for none
  vibrationMass @9 :Float64 = 0.05;   # kg: force per acceleration
}

# ---------------------------------------------------------------- the daemon

struct DaemonInfo {
  version @0 :Text;
  protocolMajor @1 :UInt16;
  protocolMinor @2 :UInt16;
  epoch @3 :UInt64;             # drawn at start; a new one means a restarted daemon
  pid @4 :Int32;
  administration @5 :Bool;      # this connection came by the administration socket
  realtime @6 :Bool;
  schedulingNote @7 :Text;      # why not, when realtime is false
  socket @8 :Text;
  configFile @9 :Text;          # empty: the embedded default
  startedNs @10 :Int64;
}

interface Daemon {
  hello @0 (clientName :Text, protocolMajor :UInt16, protocolMinor :UInt16) -> (status :Status, info :DaemonInfo);

  listDevices @1 () -> (status :Status, devices :List(DeviceInfo));
  # Opened devices first, then those found but not opened, then those configured and missing.

  openDevice @2 (uri :Text) -> (status :Status, device :DeviceInfo);
  # By URI or serial; opening what is open answers with it. An empty URI: the first open device; if none
  # is open, the first real one, else the simulator.

  closeDevice @3 (uri :Text) -> (status :Status);
  # Administration; or who alone has asked for it, of no hardware and not configured. Refused while a session holds it.
  # Answered when its force has been lowered; of a servo that stands still in two seconds, by a refusal (WOULD_BLOCK) or,
  # for administration, all the same.

  openSession @4 (uri :Text, clientName :Text, layoutMajor :UInt16, layoutMinor :UInt16)
      -> (status :Status, session :Session, info :SessionInfo);

  scene @5 () -> (status :Status, scene :Scene);

  get @6 (path :Text) -> (status :Status, json :Text);
  # Resource names: /objects/C/pos, /_objects/A/B/C, /devices/NAME/..., /statistics, ...

  set @7 (uri :Text) -> (status :Status, json :Text);
  # /objects/C/pos?value=1,2,3 ; answers with the value now in force.

  state @8 () -> (status :Status, state :DaemonState);

  statistics @9 (uri :Text, reset :Bool) -> (status :Status, statistics :Statistics);
  # Reset takes the administration socket.

  subscribe @10 (listener :EventListener, kinds :UInt32) -> (status :Status, subscription :Subscription);
  # kinds: a bit (1 << EventKind) each; 0 means all.

  stop @11 (uri :Text) -> (status :Status);
  # Zero force at once and latch until re-armed. Anybody may stop anything; an empty URI stops every device.

  setLimits @12 (uri :Text, limits :Limits) -> (status :Status, limits :Limits);
  # Lowering: the lease holder's user or administration; raising: administration. Answers with the limits in force.

  configuration @13 () -> (status :Status, toml :Text);
  doctor @14 () -> (status :Status, checks :List(Check));
  dump @15 () -> (status :Status, json :Text);

  record @16 (uri :Text) -> (status :Status, recording :Recording);
  # All that enters the servo of the device's group and what comes out (docs/recording.md). No device of it may be
  # armed. Administration, where another user has a session.
}

interface Recording {
  stream @0 () -> (status :Status, stream :Region);
  # Once. To be read until its end; who reads too slowly ends the recording.
  stop @1 () -> (status :Status, reason :Text, cycles :UInt64, lost :UInt64);
  # Answers when all is in the stream; also tells how a recording ended that ended by itself.
}
# Dropping it ends the recording.

struct Check {
  name @0 :Text;
  state @1 :State;
  detail @2 :Text;
  remedy @3 :Text;
  enum State { green @0; red @1; notApplicable @2; }
}

# ---------------------------------------------------------------- devices

struct Limits {
  force @0 :Float64;          # N
  torque @1 :Float64;         # N m
  forceSlew @2 :Float64;      # N/s
  torqueSlew @3 :Float64;     # N m/s
  velocity @4 :Float64;       # m/s: beyond it the guard latches
  power @5 :Float64;          # W delivered to the hand
  activePower @6 :Float64;    # W: budget of sources declared active
  gripperForce @7 :Float64;   # N
}

enum CalibrationState { notNeeded @0; needed @1; running @2; done @3; }

struct DeviceInfo {
  uri @0 :Text;               # canonical: opens this device and no other
  name @1 :Text;              # short, unique in this daemon: used in resource names
  model @2 :Text;
  manufacturer @3 :Text;
  serial @4 :Text;
  firmware @5 :Text;
  driver @6 :Text;
  driverVersion @7 :Text;
  open @8 :Bool;
  maxForce @9 :Float64;             # N, peak
  continuousForce @10 :Float64;     # N
  maxTorque @11 :Float64;           # N m
  maxGripperForce @12 :Float64;     # N
  maxStiffness @13 :Float64;        # N/m, closed loop at 1 kHz
  maxAngularStiffness @14 :Float64; # N m/rad
  maxGripperStiffness @15 :Float64; # N/m
  maxDamping @16 :Float64;          # N s/m
  maxAngularDamping @17 :Float64;   # N m s/rad
  workspaceRadius @18 :Float64;     # m
  workspaceLower @19 :Vec3;         # usable box
  workspaceUpper @20 :Vec3;
  maxWorkspaceLower @21 :Vec3;      # reachable box
  maxWorkspaceUpper @22 :Vec3;
  gripperMaxAngle @23 :Float64;     # rad
  positionResolution @24 :Float64;  # m
  rotationResolution @25 :Float64;  # rad
  forceResolution @26 :Float64;     # N
  nativeRate @27 :Float64;          # Hz
  apparentMass @28 :Float64;        # kg
  viscousFriction @29 :Float64;     # N s/m
  coulombFriction @30 :Float64;     # N
  maxVelocity @31 :Float64;         # m/s
  sensedPosition @32 :Bool;
  sensedRotation @33 :Bool;
  sensedGripper @34 :Bool;
  actuatedPosition @35 :Bool;
  actuatedRotation @36 :Bool;
  actuatedGripper @37 :Bool;
  leftHand @38 :Bool;
  rightHand @39 :Bool;
  buttons @40 :UInt32;
  calibrationStyle @41 :Text;       # none, encoder reset, auto, inkwell
  calibration @42 :CalibrationState;
  hasBrakes @43 :Bool;
  hasWatchdog @44 :Bool;
  hasDeadman @45 :Bool;
  hasVelocityLimit @46 :Bool;
  temperatureC @47 :Float64;        # hottest motor; NaN where not sensed
  problem @48 :Text;                # why it is not open although it is to be; empty otherwise
}

struct DeviceState {
  uri @0 :Text;
  name @1 :Text;
  armed @2 :Bool;             # Forces may reach it: also while its driver has not sent the zeros.
  fault @3 :UInt16;           # hd_fault
  faultText @4 :Text;
  leaseHolder @5 :Text;       # client name, empty if free
  leasePid @6 :Int32;
  rateHz @7 :Float64;
  cycles @8 :UInt64;
  missed @9 :UInt64;
  stale @10 :UInt64;
  busy @11 :Float64;          # fraction of the period spent in the cycle, median
  wakeP99Ns @12 :UInt32;
  limits @13 :Limits;
  pose @14 :Pose;
  force @15 :Vec3;
  group @16 :Text;
  schedulingPolicy @17 :Text; # "SCHED_FIFO 80" or "SCHED_OTHER"
  flags @18 :UInt32;          # hd_sample_flag
  velocity @19 :Vec3;         # m/s
  torque @20 :Vec3;           # N m
  proxy @21 :Vec3;            # m
  buttons @22 :UInt32;
  index @23 :UInt32;          # in the group: hd_sample.device
}

struct ClientState {
  session @0 :UInt64;
  name @1 :Text;
  pid @2 :Int32;
  uid @3 :UInt32;
  device @4 :Text;
  lease @5 :Bool;
  received @6 :UInt64;        # commands taken, by ring and mailboxes, those refused too
  rejected @7 :UInt64;
  stale @8 :UInt64;
  models @9 :UInt32;          # local models in force
  fade @10 :Float32;
  heartbeatAgeNs @11 :Int64;
  bytes @12 :UInt64;          # locked for this session
}

struct DaemonState {
  info @0 :DaemonInfo;
  devices @1 :List(DeviceState);
  clients @2 :List(ClientState);
  objects @3 :UInt32;
  triangles @4 :UInt64;
  lockedBytes @5 :UInt64;
  uptimeNs @6 :Int64;
  meshes @7 :UInt32;
}

struct Histogram {
  name @0 :Text;              # wake, read, render, guard, write, cycle, collide
  count @1 :UInt64;
  p50Ns @2 :UInt64;
  p99Ns @3 :UInt64;
  p999Ns @4 :UInt64;
  p9999Ns @5 :UInt64;
  maxNs @6 :UInt64;
}

struct Statistics {
  uri @0 :Text;
  periodNs @1 :Int64;
  cycles @2 :UInt64;
  missed @3 :UInt64;
  overruns @4 :UInt64;
  staleSamples @5 :UInt64;
  histograms @6 :List(Histogram);
  collideQueries @7 :UInt64;    # answers of the collide thread on held tools and free objects
  collideExhausted @8 :UInt64;  # of them, those whose time or work was not enough
  collideUnsent @9 :UInt64;     # of them, those that the servo had no room for
}

# ---------------------------------------------------------------- sessions

struct SessionInfo {
  id @0 :UInt64;
  epoch @1 :UInt64;
  device @2 :DeviceInfo;
  deviceIndex @3 :UInt32;     # in the group: hd_sample.device
  deviceCount @4 :UInt32;
  periodNs @5 :Int64;
  regionABytes @6 :UInt64;
  regionBBytes @7 :UInt64;
}

interface Region {}
# Carries one descriptor (getFd).

interface Session {
  regions @0 () -> (status :Status, a :Region, b :Region);
  mapped @1 () -> (status :Status);
  # The client has both mapped; the daemon seals B against new writable maps and starts reading it.
  acquireLease @2 () -> (status :Status);
  releaseLease @3 () -> (status :Status);
  arm @4 () -> (status :Status);
  # Takes the lease; clears a latched fault whose cause is gone; ramps up over two seconds once the force asked for is small.
  disarm @5 () -> (status :Status);
}
# Dropping the capability or the connection ends the session: its share of the force fades, its lease is released.

# ---------------------------------------------------------------- the scene

enum ShapeKind { group @0; plane @1; sphere @2; box @3; capsule @4; cylinder @5; mesh @6; }

struct Shape {
  kind @0 :ShapeKind;
  size @1 :Vec3;      # box: half-extents; sphere: x radius; capsule, cylinder: x radius, y half-length (axis z); plane: normal +z
  mesh @2 :UInt64;    # mesh id, for kind mesh
}

struct ObjectSpec {
  name @0 :Text;      # identifier, unique; [A-Za-z0-9_.-]+, at most 63 bytes
  parent @1 :Text;    # name of the parent, empty for the root
  pose @2 :Pose;      # in the parent's frame
  shape @3 :Shape;
  material @4 :Material;  # none: 500 N/m, 0.5 N s/m, mu 0.4 and 0.3
  enabled @5 :Bool = true;
  visible @6 :Bool = true;
  twoSided @7 :Bool;
  keep @8 :Bool;      # stays when the client that made it leaves
  surface @9 :Surface;
}

struct ObjectState {
  spec @0 :ObjectSpec;
  id @1 :UInt32;      # for the rings
  worldPose @2 :Pose;
  path @3 :Text;      # /_objects/A/B/C
  owner @4 :Text;       # name of the client that made it, empty when that has left
  triangles @5 :UInt32;
  velocity @6 :Vec3;    # m/s, in the parent's frame
  angularVelocity @7 :Vec3;
}

struct MeshReport {
  id @0 :UInt64;
  vertices @1 :UInt32;
  triangles @2 :UInt32;
  bytes @3 :UInt64;
  lower @4 :Vec3;
  upper @5 :Vec3;
  closed @6 :Bool;
  notes @7 :List(Text);  # repairs, each naming its triangle
  buildNs @8 :Int64;
  deformable @9 :Bool;   # vertex moves through the ring are possible
  uses @10 :UInt32;      # objects that show it
  owner @11 :Text;
}

struct TextureReport {
  id @0 :UInt64;
  relief @1 :Bool;      # a relief, else a vibration
  width @2 :UInt32;     # of a relief, pixels
  height @3 :UInt32;
  models @4 :UInt32;    # of a vibration
  rate @5 :Float64;     # Hz it was recorded at
  bytes @6 :UInt64;     # of each copy: one for the servos of a rate
  uses @7 :UInt32;      # surfaces that show it
  owner @8 :Text;
}

interface Progress {
  report @0 (fraction :Float32, stage :Text) -> stream;
}

interface Upload {
  region @0 () -> (status :Status, region :Region);
  commit @1 (progress :Progress) -> (status :Status, mesh :MeshReport);
  # The client has unmapped it; STILL_MAPPED otherwise. Dropping the capability cancels.
  commitTexture @2 () -> (status :Status, texture :TextureReport);
  # What was filled is a texture (texture.h) instead of a mesh.
}

interface Scene {
  create @0 (object :ObjectSpec) -> (status :Status, id :UInt32);
  remove @1 (name :Text) -> (status :Status);  # with its children
  list @2 () -> (status :Status, objects :List(ObjectState));
  find @3 (name :Text) -> (status :Status, object :ObjectState);
  setPose @4 (name :Text, pose :Pose) -> (status :Status);
  setMaterial @5 (name :Text, material :Material) -> (status :Status);
  setFlags @6 (name :Text, enabled :Bool, visible :Bool, twoSided :Bool) -> (status :Status);
  setShape @7 (name :Text, shape :Shape) -> (status :Status);
  beginUpload @8 (bytes :UInt64) -> (status :Status, upload :Upload);
  # bytes: sizeof(hd_mesh_upload) + 12 per vertex + 12 per triangle; for a texture as texture.h says.
  dropMesh @9 (mesh :UInt64) -> (status :Status);
  # Refused while an object shows it. A mesh goes with the client that made it once no object shows it.
  listMeshes @10 () -> (status :Status, meshes :List(MeshReport));
  setSurface @11 (name :Text, surface :Surface) -> (status :Status);
  dropTexture @12 (texture :UInt64) -> (status :Status);
  # Refused while a surface shows it. A texture goes with the client that made it once no surface shows it.
  listTextures @13 () -> (status :Status, textures :List(TextureReport));
  volumeFile @14 (name :Text) -> (status :Status, file :Region);
  # To be read: the volume of an object's mesh as an OpenVDB file. For its maker's user or administration. WOULD_BLOCK
  # while it is being made; NOT_FOUND if there is none.
}

# ---------------------------------------------------------------- events

enum EventKind {
  touch @0; untouch @1; button @2; fault @3; armed @4; disarmed @5; leaseLost @6; leaseTaken @7;
  deviceAdded @8; deviceRemoved @9; overrun @10; clientJoined @11; clientLeft @12; modelExpired @13; objectChanged @14;
  refused @15;
}

struct Event {
  kind @0 :EventKind;
  tNs @1 :Int64;
  tick @2 :UInt64;
  device @3 :Text;
  object @4 :Text;
  session @5 :UInt64;
  value @6 :UInt32;      # button mask, fault number, missed periods, model slot, number of the error
  point @7 :Vec3;
  force @8 :Float64;     # N, as the surface asks for; a hand that is not armed feels none
  text @9 :Text;
}

interface EventListener {
  events @0 (events :List(Event), lost :UInt64) -> ();
  # One call in flight at a time; lost counts what did not fit between.
}

interface Subscription {}
# Drop to unsubscribe.
