#include "daemon/rpc/convert.h"

#include <fmt/format.h>

#include <new>

namespace hapticd {
namespace {

/** Length of the UTF-8 sequence that starts at `s`, 0 if it is malformed (RFC 3629, section 4). */
std::size_t utf8Length(const unsigned char* s, std::size_t left) {
  const auto tail = [&](std::size_t i) { return i < left && (s[i] & 0xc0u) == 0x80u; };
  if (s[0] < 0x80) return 1;
  if (s[0] >= 0xc2 && s[0] <= 0xdf) return tail(1) ? 2 : 0;
  if (s[0] >= 0xe0 && s[0] <= 0xef) {
    if (!tail(1) || !tail(2)) return 0;
    if (s[0] == 0xe0 && s[1] < 0xa0) return 0;  // overlong
    if (s[0] == 0xed && s[1] > 0x9f) return 0;  // surrogates
    return 3;
  }
  if (s[0] >= 0xf0 && s[0] <= 0xf4) {
    if (!tail(1) || !tail(2) || !tail(3)) return 0;
    if (s[0] == 0xf0 && s[1] < 0x90) return 0;
    if (s[0] == 0xf4 && s[1] > 0x8f) return 0;
    return 4;
  }
  return 0;
}

}  // namespace

capnp::Text::Reader text(const std::string& in) { return {in.data(), in.size()}; }

void setStatus(proto::Status::Builder out, const Result<void>& result) {
  if (result) return;
  const Error& error = result.error();
  out.setCode(static_cast<std::uint16_t>(error.code));
  try {
    out.setWhere(text(error.where));
    out.setWhat(error.what.empty() ? capnp::Text::Reader(describe(error.code).data(), describe(error.code).size())
                                   : text(error.what));
    out.setRemedy(text(error.remedy));
  } catch (const std::exception&) {  // No memory, which kj tells by its own. The code says it.
  }
}

Result<void> checkText(capnp::Text::Reader in, std::size_t most, const char* where) {
  if (in.size() > most) {
    return Error{ErrorCode::kInvalidArgument, where, fmt::format("it has {} bytes; {} is the most", in.size(), most),
                 "shorten it"};
  }
  const auto* s = reinterpret_cast<const unsigned char*>(in.begin());
  for (std::size_t i = 0; i < in.size();) {
    const std::size_t n = utf8Length(s + i, in.size() - i);
    const bool control = s[i] < 0x20 || s[i] == 0x7f || (s[i] == 0xc2 && n == 2 && s[i + 1] < 0xa0);
    if (n == 0 || control) {
      return Error{ErrorCode::kInvalidArgument, where,
                   fmt::format("byte {} (0x{:02x}) is not printable UTF-8", i, s[i]),
                   "write it in UTF-8, without control characters"};
    }
    i += n;
  }
  return {};
}

Result<std::string> readText(capnp::Text::Reader in, std::size_t most, const char* where) {
  if (auto r = checkText(in, most, where); !r) return r.error();
  return std::string(in.begin(), in.size());
}

Vec3 read(proto::Vec3::Reader in) { return {in.getX(), in.getY(), in.getZ()}; }

Pose read(proto::Pose::Reader in) {
  const auto q = in.getQ();
  return {read(in.getP()), Quat(q.getW(), q.getX(), q.getY(), q.getZ())};
}

hd_material read(proto::Material::Reader in) {
  return {in.getStiffness(), in.getDamping(), in.getFrictionStatic(), in.getFrictionDynamic()};
}

SurfaceSpec read(proto::Surface::Reader in) {
  return {in.getSmoothDeg(), in.getTransientGain(), in.getTransientHz(), in.getTransientDecay(),
          in.getRelief(),    in.getReliefDepth(),   in.getReliefWidth(), in.getReliefHeight(),
          in.getVibration(), in.getVibrationMass()};
}

ShapeSpec read(proto::Shape::Reader in) {
  ShapeSpec out{static_cast<ShapeKind>(in.getKind()), read(in.getSize()), in.getMesh()};
  // Numbers that its kind does not have say nothing, and are not told to who asks.
  if (out.kind == ShapeKind::kSphere) out.size.y() = 0;
  if (out.kind != ShapeKind::kBox) out.size.z() = 0;
  if (out.kind == ShapeKind::kGroup || out.kind == ShapeKind::kPlane || out.kind == ShapeKind::kMesh)
    out.size.setZero();
  return out;
}

GuardLimits read(proto::Limits::Reader in) {
  GuardLimits out;
  out.force = in.getForce();
  out.torque = in.getTorque();
  out.force_slew = in.getForceSlew();
  out.torque_slew = in.getTorqueSlew();
  out.velocity = in.getVelocity();
  out.power = in.getPower();
  out.active_power = in.getActivePower();
  out.gripper_force = in.getGripperForce();
  return out;
}

Result<ObjectSpec> read(proto::ObjectSpec::Reader in) {
  ObjectSpec out;
  auto name = readText(in.getName(), kMostName, "object.name");
  if (!name) return name.error();
  auto parent = readText(in.getParent(), kMostName, "object.parent");
  if (!parent) return parent.error();
  out.name = std::move(*name);
  out.parent = std::move(*parent);
  out.X_PO = read(in.getPose());
  out.shape = read(in.getShape());
  out.material = in.hasMaterial() ? read(in.getMaterial()) : kDefaultMaterial;
  out.surface = read(in.getSurface());
  out.flags = {in.getEnabled(), in.getVisible(), in.getTwoSided()};
  out.keep = in.getKeep();
  return out;
}

void write(proto::Vec3::Builder out, const Vec3& in) {
  out.setX(in.x());
  out.setY(in.y());
  out.setZ(in.z());
}

void write(proto::Vec3::Builder out, const double (&in)[3]) { write(out, vec3(in)); }

void write(proto::Pose::Builder out, const Pose& in) {
  write(out.initP(), in.p);
  auto q = out.initQ();
  q.setW(in.q.w());
  q.setX(in.q.x());
  q.setY(in.q.y());
  q.setZ(in.q.z());
}

void write(proto::Material::Builder out, const hd_material& in) {
  out.setStiffness(in.stiffness);
  out.setDamping(in.damping);
  out.setFrictionStatic(in.friction_static);
  out.setFrictionDynamic(in.friction_dynamic);
}

void write(proto::Surface::Builder out, const SurfaceSpec& in) {
  out.setSmoothDeg(in.smooth_deg);
  out.setTransientGain(in.transient_gain);
  out.setTransientHz(in.transient_hz);
  out.setTransientDecay(in.transient_decay_s);
  out.setRelief(in.relief);
  out.setReliefDepth(in.relief_depth);
  out.setReliefWidth(in.relief_width);
  out.setReliefHeight(in.relief_height);
  out.setVibration(in.vibration);
  out.setVibrationMass(in.vibration_mass);
}

void write(proto::TextureReport::Builder out, const TextureInfo& in) {
  out.setId(in.id);
  out.setRelief(in.is_relief);
  out.setWidth(in.width);
  out.setHeight(in.height);
  out.setModels(in.models);
  out.setRate(in.rate_hz);
  out.setBytes(in.bytes);
  out.setUses(in.uses);
  out.setOwner(text(in.owner.name));
}

void write(proto::Limits::Builder out, const GuardLimits& in) {
  out.setForce(in.force);
  out.setTorque(in.torque);
  out.setForceSlew(in.force_slew);
  out.setTorqueSlew(in.torque_slew);
  out.setVelocity(in.velocity);
  out.setPower(in.power);
  out.setActivePower(in.active_power);
  out.setGripperForce(in.gripper_force);
}

void write(proto::DeviceInfo::Builder out, const DeviceInfo& in) {
  out.setUri(text(in.uri));
  out.setModel(text(in.model));
  out.setManufacturer(text(in.manufacturer));
  out.setSerial(text(in.serial));
  out.setFirmware(text(in.firmware));
  out.setDriver(text(in.driver));
  out.setDriverVersion(text(in.driver_version));
  out.setMaxForce(in.max_force);
  out.setContinuousForce(in.continuous_force);
  out.setMaxTorque(in.max_torque);
  out.setMaxGripperForce(in.max_gripper_force);
  out.setMaxStiffness(in.max_stiffness);
  out.setMaxAngularStiffness(in.max_angular_stiffness);
  out.setMaxGripperStiffness(in.max_gripper_stiffness);
  out.setMaxDamping(in.max_damping);
  out.setMaxAngularDamping(in.max_angular_damping);
  out.setWorkspaceRadius(in.workspace_radius);
  write(out.initWorkspaceLower(), in.workspace_lower);
  write(out.initWorkspaceUpper(), in.workspace_upper);
  write(out.initMaxWorkspaceLower(), in.max_workspace_lower);
  write(out.initMaxWorkspaceUpper(), in.max_workspace_upper);
  out.setGripperMaxAngle(in.gripper_max_angle);
  out.setPositionResolution(in.position_resolution);
  out.setRotationResolution(in.rotation_resolution);
  out.setForceResolution(in.force_resolution);
  out.setNativeRate(in.native_rate_hz);
  out.setApparentMass(in.apparent_mass);
  out.setViscousFriction(in.viscous_friction);
  out.setCoulombFriction(in.coulomb_friction);
  out.setMaxVelocity(in.max_velocity);
  out.setSensedPosition(in.sensed_position);
  out.setSensedRotation(in.sensed_rotation);
  out.setSensedGripper(in.sensed_gripper);
  out.setActuatedPosition(in.actuated_position);
  out.setActuatedRotation(in.actuated_rotation);
  out.setActuatedGripper(in.actuated_gripper);
  out.setLeftHand(in.left_hand);
  out.setRightHand(in.right_hand);
  out.setButtons(in.buttons);
  out.setCalibrationStyle(text(in.calibration_style));
  out.setHasBrakes(in.has_brakes);
  out.setHasWatchdog(in.has_watchdog);
  out.setHasDeadman(in.has_deadman);
  out.setHasVelocityLimit(in.has_velocity_limit);
  out.setTemperatureC(std::numeric_limits<double>::quiet_NaN());
}

void write(proto::DeviceInfo::Builder out, const OpenDevice& in) {
  write(out, in.info());
  out.setName(text(in.name));
  out.setOpen(true);
  out.setCalibration(static_cast<proto::CalibrationState>(in.device().calibration()));
  out.setTemperatureC(in.device().temperature());
}

void write(proto::ObjectState::Builder out, const ObjectNow& in) {
  auto spec = out.initSpec();
  spec.setName(text(in.spec.name));
  spec.setParent(text(in.spec.parent));
  write(spec.initPose(), in.spec.X_PO);
  auto shape = spec.initShape();
  shape.setKind(static_cast<proto::ShapeKind>(in.spec.shape.kind));
  write(shape.initSize(), in.spec.shape.size);
  shape.setMesh(in.spec.shape.mesh);
  write(spec.initMaterial(), in.spec.material);
  write(spec.initSurface(), in.spec.surface);
  spec.setEnabled(in.spec.flags.enabled);
  spec.setVisible(in.spec.flags.visible);
  spec.setTwoSided(in.spec.flags.two_sided);
  spec.setKeep(in.spec.keep);
  out.setId(in.id);
  write(out.initWorldPose(), in.X_WO);
  out.setPath(text(in.path));
  out.setOwner(text(in.owner));
  out.setTriangles(in.triangles);
  write(out.initVelocity(), in.V_PO.v);
  write(out.initAngularVelocity(), in.V_PO.w);
}

void write(proto::MeshReport::Builder out, const MeshInfo& in) {
  out.setId(in.id);
  out.setVertices(in.vertices);
  out.setTriangles(in.triangles);
  out.setBytes(in.bytes);
  write(out.initLower(), in.lower);
  write(out.initUpper(), in.upper);
  out.setClosed(in.closed);
  auto notes = out.initNotes(static_cast<unsigned>(in.notes.size()));
  for (unsigned i = 0; i < notes.size(); ++i) notes.set(i, text(in.notes[i]));
  out.setBuildNs(in.build_ns);
  out.setDeformable(in.deformable);
  out.setUses(in.uses);
  out.setOwner(text(in.owner.name));
}

void write(proto::Event::Builder out, const Event& in) {
  out.setKind(static_cast<proto::EventKind>(in.kind));
  out.setTNs(in.t_ns);
  out.setTick(in.tick);
  out.setDevice(text(in.device));
  out.setObject(text(in.object));
  out.setSession(in.session);
  out.setValue(in.value);
  write(out.initPoint(), in.point);
  out.setForce(in.force);
  out.setText(text(in.text));
}

}  // namespace hapticd
