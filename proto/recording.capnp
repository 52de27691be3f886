@0xd2c4a51b9e7f3086;
# A recording: everything that entered the cycles of one device group, and what each device was sent. docs/recording.md
# says how blocks are framed and in which order they come.
#
# Numbers are SI; what devices read and were sent is in their own frame, all else in the world's, and where a device
# stands is an order (SetMount of rt/command.h); quaternions w, x, y, z. Evolution: add at the end with the next ordinal; never
# renumber, never retype.

using Cxx = import "/capnp/c++.capnp";
$Cxx.namespace("hapticd::proto");

const recordingMajor :UInt16 = 1;   # readers refuse another one
const recordingMinor :UInt16 = 1;   # fields were added; 1: texturePart
const ordersVersion :UInt16 = 2;    # layout of the daemon's own orders (rt/command.h); a reader refuses another one

struct Block {
  union {
    header @0 :Header;              # the first
    meshPart @1 :MeshPart;          # parts of a mesh follow each other, and stand before the first cycle that uses it
    cycles @2 :List(CycleRecord);
    end @3 :End;                    # the last, unless the recording was cut off
    texturePart @4 :TexturePart;    # parts of a relief follow each other; before the first cycle that uses it
  }
}

struct Header {
  major @0 :UInt16;
  minor @1 :UInt16;
  orders @2 :UInt16;                # ordersVersion
  layoutMajor @3 :UInt16;           # of shm_layout.h, for the clients' messages
  layoutMinor @4 :UInt16;
  program @5 :Text;                 # version of hapticd
  build @6 :Text;                   # checksum of the real-time library: the same text, the same instructions
  instructions @7 :Text;            # what the library chose at run time, and the C library
  startedNs @8 :Int64;              # CLOCK_REALTIME, ns since 1970
  flushDenormals @9 :Bool;          # the servo ran with denormals as zero
  group @10 :Text;
  devices @11 :List(DeviceStart);
  periodNs @12 :Int64;
  lossFadeNs @13 :Int64;
  tick @14 :UInt64;                 # of the cycle before the first
  nowNs @15 :Int64;                 # its time, on the clock of every nowNs and tNs below
  orderList @16 :List(Order);       # applied to a new cycle before the first
  meshes @17 :UInt32;               # how many stand before the first cycle
}

struct DeviceStart {
  name @0 :Text;
  uri @1 :Text;
  model @2 :Text;
  positionResolution @3 :Float64;   # m
  rotationResolution @4 :Float64;   # rad
  limits @5 :GuardLimits;
  rampNs @6 :Int64;
  smallForce @7 :Float64;           # N
  smallTorque @8 :Float64;          # N m
  smallForceTicks @9 :UInt32;
  staleNs @10 :Int64;
  missedLimit @11 :UInt32;
  passivity @12 :Bool;
  maxDamping @13 :Float64;          # N s/m
  energyLimit @14 :Float64;         # J
  delay @15 :Float64;               # ticks
  continuousForce @16 :Float64;     # N; 0: no heating estimate
  peakForce @17 :Float64;           # N
  heatingS @18 :Float64;            # s
  heat @19 :Float64;                # of the motors at the start
  lifeNs @20 :Int64;                # of a command that no other follows; 0: until the next
}

struct GuardLimits {
  force @0 :Float64;                # N
  torque @1 :Float64;               # N m
  forceSlew @2 :Float64;            # N/s
  torqueSlew @3 :Float64;           # N m/s
  gripperForce @4 :Float64;         # N
  velocity @5 :Float64;             # m/s
  power @6 :Float64;                # W
  activePower @7 :Float64;          # W
}

struct Order {
  kind @0 :UInt32;                  # below 64 hd_command_kind, else CommandKind of rt/command.h
  session @1 :UInt32;               # slot of the sender
  seq @2 :UInt64;
  atTick @3 :UInt64;
  channel @4 :UInt32;
  payload @5 :Data;                 # the C struct of that kind; zeros at its end are left out
}

struct MeshPart {
  entry @0 :UInt32;                 # of the mesh table, by which orders name it
  size @1 :UInt64;                  # of the whole snapshot (proto/snapshot.h)
  offset @2 :UInt64;                # of this part
  bytes @3 :Data;
}

struct TexturePart {
  entry @0 :UInt32;                 # of the texture table; orders name it by one more
  union {
    relief @1 :ReliefPart;
    vibration @2 :Vibration;        # always whole
  }
}

struct ReliefPart {
  width @0 :UInt32;                 # of the whole picture, pixels
  height @1 :UInt32;
  offset @2 :UInt32;                # of the first pixel of this part, counted row by row from the upper edge
  pixels @3 :List(UInt16);          # grey
}

struct Vibration {                  # as the servo reads it: models at its rate (docs/surfaces.md)
  models @0 :List(VibrationModel);
  triangles @1 :List(UInt16);       # three models each
}

struct VibrationModel {
  speed @0 :Float64;                # m/s
  force @1 :Float64;                # N
  power @2 :Float64;                # of the acceleration, m^2/s^4
  reflection @3 :List(Float64);     # coefficients of the lattice
}

struct CycleRecord {
  tick @0 :UInt64;
  nowNs @1 :Int64;
  missed @2 :UInt32;
  stopLine @3 :Bool;
  deadmanOpen @4 :Bool;
  devices @5 :List(DeviceRecord);
  orders @6 :List(Order);
}

struct DeviceRecord {
  tNs @0 :Int64;
  px @1 :Float64;
  py @2 :Float64;
  pz @3 :Float64;
  qw @4 :Float64;
  qx @5 :Float64;
  qy @6 :Float64;
  qz @7 :Float64;
  vx @8 :Float64;                   # the device's own, if hasVelocity
  vy @9 :Float64;
  vz @10 :Float64;
  wx @11 :Float64;
  wy @12 :Float64;
  wz @13 :Float64;
  gripperRad @14 :Float64;
  buttons @15 :UInt32;
  status @16 :UInt32;               # DeviceStatus of rt/device.h
  fresh @17 :Bool;
  hasVelocity @18 :Bool;
  enabled @19 :Bool;                # what follows was sent
  fx @20 :Float64;
  fy @21 :Float64;
  fz @22 :Float64;
  tx @23 :Float64;
  ty @24 :Float64;
  tz @25 :Float64;
  gripperForce @26 :Float64;
  gravityX @27 :Float64;            # DeviceSample.gravity; recordings made before it was there have zeros
  gravityY @28 :Float64;
  gravityZ @29 :Float64;
}

struct End {
  reason @0 :Text;
  cycles @1 :UInt64;                # in the recording
  lost @2 :UInt64;                  # cycles that found no room, after the last one here
}
