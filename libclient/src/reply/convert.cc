#include "libclient/src/reply/convert.h"

#include <string_view>

namespace hapticd::client {
namespace {

const char* text(Reply& reply, capnp::Text::Reader from) {
  return reply.text(std::string_view(from.cStr(), from.size()));
}

void convertPose(proto::Pose::Reader from, haptic_pose& to) {
  convert(from.getP(), to.p);
  const auto q = from.getQ();
  to.q[0] = q.getW();
  to.q[1] = q.getX();
  to.q[2] = q.getY();
  to.q[3] = q.getZ();
}

using client::convert;

std::uint32_t bit(bool set, std::uint32_t flag) { return set ? flag : 0; }

haptic_device_status* convert(proto::DeviceState::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_device_status>();
  to->armed = from.getArmed();
  to->fault = from.getFault();
  to->lease_pid = from.getLeasePid();
  to->uri = text(reply, from.getUri());
  to->name = text(reply, from.getName());
  to->fault_text = text(reply, from.getFaultText());
  to->lease_holder = text(reply, from.getLeaseHolder());
  to->group = text(reply, from.getGroup());
  to->scheduling = text(reply, from.getSchedulingPolicy());
  to->rate_hz = from.getRateHz();
  to->busy = from.getBusy();
  to->cycles = from.getCycles();
  to->missed = from.getMissed();
  to->stale = from.getStale();
  to->wake_p99_ns = from.getWakeP99Ns();
  auto* limits = reply.make<haptic_device_limits>();
  *limits = convert(from.getLimits());
  to->limits = limits;
  convertPose(from.getPose(), to->pose);
  convert(from.getForce(), to->force);
  return to;
}

haptic_client_status* convert(proto::ClientState::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_client_status>();
  to->pid = from.getPid();
  to->uid = from.getUid();
  to->lease = from.getLease();
  to->session = from.getSession();
  to->name = text(reply, from.getName());
  to->device = text(reply, from.getDevice());
  to->received = from.getReceived();
  to->rejected = from.getRejected();
  to->stale = from.getStale();
  to->models = from.getModels();
  to->fade = from.getFade();
  to->heartbeat_age_ns = from.getHeartbeatAgeNs();
  to->bytes = from.getBytes();
  return to;
}

haptic_histogram* convert(proto::Histogram::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_histogram>();
  to->name = text(reply, from.getName());
  to->count = from.getCount();
  to->p50_ns = from.getP50Ns();
  to->p99_ns = from.getP99Ns();
  to->p999_ns = from.getP999Ns();
  to->p9999_ns = from.getP9999Ns();
  to->max_ns = from.getMaxNs();
  return to;
}

haptic_check* convert(proto::Check::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_check>();
  to->state = static_cast<std::uint32_t>(from.getState());
  to->name = text(reply, from.getName());
  to->detail = text(reply, from.getDetail());
  to->remedy = text(reply, from.getRemedy());
  return to;
}

/** Converts a list's entries. */
template <class Entry, class List>
const Entry* const* entries(const List& from, std::uint32_t& count, Reply& reply) {
  count = from.size();
  auto** items = reply.makeArray<const Entry*>(count);
  for (std::uint32_t i = 0; i < count; ++i) items[i] = convert(from[i], reply);
  return items;
}

}  // namespace

haptic_device_info* convert(proto::DeviceInfo::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_device_info>();
  to->open = from.getOpen();
  to->abilities =
      bit(from.getSensedPosition(), HAPTIC_SENSES_POSITION) | bit(from.getSensedRotation(), HAPTIC_SENSES_ROTATION) |
      bit(from.getSensedGripper(), HAPTIC_SENSES_GRIPPER) | bit(from.getActuatedPosition(), HAPTIC_ACTUATES_POSITION) |
      bit(from.getActuatedRotation(), HAPTIC_ACTUATES_ROTATION) |
      bit(from.getActuatedGripper(), HAPTIC_ACTUATES_GRIPPER) | bit(from.getLeftHand(), HAPTIC_LEFT_HAND) |
      bit(from.getRightHand(), HAPTIC_RIGHT_HAND) | bit(from.getHasBrakes(), HAPTIC_HAS_BRAKES) |
      bit(from.getHasWatchdog(), HAPTIC_HAS_WATCHDOG) | bit(from.getHasDeadman(), HAPTIC_HAS_DEADMAN) |
      bit(from.getHasVelocityLimit(), HAPTIC_HAS_VELOCITY_LIMIT);
  to->buttons = from.getButtons();
  to->calibration = static_cast<std::uint32_t>(from.getCalibration());
  to->uri = text(reply, from.getUri());
  to->name = text(reply, from.getName());
  to->model = text(reply, from.getModel());
  to->manufacturer = text(reply, from.getManufacturer());
  to->serial = text(reply, from.getSerial());
  to->firmware = text(reply, from.getFirmware());
  to->driver = text(reply, from.getDriver());
  to->driver_version = text(reply, from.getDriverVersion());
  to->calibration_style = text(reply, from.getCalibrationStyle());
  to->max_force = from.getMaxForce();
  to->continuous_force = from.getContinuousForce();
  to->max_torque = from.getMaxTorque();
  to->max_gripper_force = from.getMaxGripperForce();
  to->max_stiffness = from.getMaxStiffness();
  to->max_angular_stiffness = from.getMaxAngularStiffness();
  to->max_gripper_stiffness = from.getMaxGripperStiffness();
  to->max_damping = from.getMaxDamping();
  to->max_angular_damping = from.getMaxAngularDamping();
  to->workspace_radius = from.getWorkspaceRadius();
  convert(from.getWorkspaceLower(), to->workspace_lower);
  convert(from.getWorkspaceUpper(), to->workspace_upper);
  convert(from.getMaxWorkspaceLower(), to->max_workspace_lower);
  convert(from.getMaxWorkspaceUpper(), to->max_workspace_upper);
  to->gripper_max_angle = from.getGripperMaxAngle();
  to->position_resolution = from.getPositionResolution();
  to->rotation_resolution = from.getRotationResolution();
  to->force_resolution = from.getForceResolution();
  to->native_rate_hz = from.getNativeRate();
  to->apparent_mass = from.getApparentMass();
  to->viscous_friction = from.getViscousFriction();
  to->coulomb_friction = from.getCoulombFriction();
  to->max_velocity = from.getMaxVelocity();
  to->temperature_c = from.getTemperatureC();
  to->problem = text(reply, from.getProblem());
  return to;
}

haptic_daemon_info* convert(const Connection::Info& from, Reply& reply) {
  auto* to = reply.make<haptic_daemon_info>();
  to->pid = from.pid;
  to->protocol_major = from.major;
  to->protocol_minor = from.minor;
  to->epoch = from.epoch;
  to->administration = from.administration;
  to->realtime = from.realtime;
  to->started_ns = from.started_ns;
  to->version = reply.text(from.version);
  to->scheduling_note = reply.text(from.scheduling_note);
  to->socket = reply.text(from.socket);
  to->config_file = reply.text(from.config_file);
  return to;
}

haptic_object_state* convert(proto::ObjectState::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_object_state>();
  to->id = from.getId();
  to->triangles = from.getTriangles();
  to->path = text(reply, from.getPath());
  to->owner = text(reply, from.getOwner());
  convertPose(from.getWorldPose(), to->world_pose);
  const auto spec = from.getSpec();
  auto* object = reply.make<haptic_object>();
  object->flags = bit(spec.getEnabled(), HAPTIC_OBJECT_ENABLED) | bit(spec.getVisible(), HAPTIC_OBJECT_VISIBLE) |
                  bit(spec.getTwoSided(), HAPTIC_OBJECT_TWO_SIDED) | bit(spec.getKeep(), HAPTIC_OBJECT_KEEP);
  object->name = text(reply, spec.getName());
  object->parent = text(reply, spec.getParent());
  convertPose(spec.getPose(), object->pose);
  const auto shape = spec.getShape();
  object->shape.kind = static_cast<std::uint32_t>(shape.getKind());
  convert(shape.getSize(), object->shape.size);
  object->shape.mesh = shape.getMesh();
  const auto material = spec.getMaterial();
  object->material = {material.getStiffness(), material.getDamping(), material.getFrictionStatic(),
                      material.getFrictionDynamic()};
  to->object = object;
  to->surface = convert(spec.getSurface(), reply);
  return to;
}

haptic_status* convert(proto::DaemonState::Reader from, const Connection::Info& info, Reply& reply) {
  auto* to = reply.make<haptic_status>();
  to->objects = from.getObjects();
  to->triangles = from.getTriangles();
  to->locked_bytes = from.getLockedBytes();
  to->uptime_ns = from.getUptimeNs();
  to->info = convert(info, reply);
  to->devices = entries<haptic_device_status>(from.getDevices(), to->device_count, reply);
  to->clients = entries<haptic_client_status>(from.getClients(), to->client_count, reply);
  return to;
}

haptic_statistics* convert(proto::Statistics::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_statistics>();
  to->uri = text(reply, from.getUri());
  to->period_ns = from.getPeriodNs();
  to->cycles = from.getCycles();
  to->missed = from.getMissed();
  to->overruns = from.getOverruns();
  to->stale_samples = from.getStaleSamples();
  to->histograms = entries<haptic_histogram>(from.getHistograms(), to->histogram_count, reply);
  to->collide_queries = from.getCollideQueries();
  to->collide_exhausted = from.getCollideExhausted();
  to->collide_unsent = from.getCollideUnsent();
  return to;
}

haptic_mesh_report* convert(proto::MeshReport::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_mesh_report>();
  to->closed = from.getClosed();
  to->id = from.getId();
  to->vertices = from.getVertices();
  to->triangles = from.getTriangles();
  to->bytes = from.getBytes();
  convert(from.getLower(), to->lower);
  convert(from.getUpper(), to->upper);
  to->build_ns = from.getBuildNs();
  const auto notes = from.getNotes();
  to->note_count = notes.size();
  auto** items = reply.makeArray<const char*>(notes.size());
  for (std::uint32_t i = 0; i < notes.size(); ++i) items[i] = text(reply, notes[i]);
  to->notes = items;
  return to;
}

haptic_check_list* convert(capnp::List<proto::Check>::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_check_list>();
  to->items = entries<haptic_check>(from, to->count, reply);
  return to;
}

haptic_device_list* convert(capnp::List<proto::DeviceInfo>::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_device_list>();
  to->items = entries<haptic_device_info>(from, to->count, reply);
  return to;
}

haptic_object_list* convert(capnp::List<proto::ObjectState>::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_object_list>();
  to->items = entries<haptic_object_state>(from, to->count, reply);
  return to;
}

haptic_mesh_list* convert(capnp::List<proto::MeshReport>::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_mesh_list>();
  to->items = entries<haptic_mesh_report>(from, to->count, reply);
  return to;
}

haptic_device_limits convert(proto::Limits::Reader from) {
  return {sizeof(haptic_device_limits),
          0,
          from.getForce(),
          from.getTorque(),
          from.getForceSlew(),
          from.getTorqueSlew(),
          from.getVelocity(),
          from.getPower(),
          from.getActivePower(),
          from.getGripperForce()};
}

void fill(const haptic_device_limits& from, proto::Limits::Builder to) {
  to.setForce(from.force);
  to.setTorque(from.torque);
  to.setForceSlew(from.force_slew);
  to.setTorqueSlew(from.torque_slew);
  to.setVelocity(from.velocity);
  to.setPower(from.power);
  to.setActivePower(from.active_power);
  to.setGripperForce(from.gripper_force);
}

void fill(const haptic_pose& from, proto::Pose::Builder to) {
  auto p = to.initP();
  p.setX(from.p[0]);
  p.setY(from.p[1]);
  p.setZ(from.p[2]);
  auto q = to.initQ();
  q.setW(from.q[0]);
  q.setX(from.q[1]);
  q.setY(from.q[2]);
  q.setZ(from.q[3]);
}

void fill(const haptic_material& from, proto::Material::Builder to) {
  to.setStiffness(from.stiffness);
  to.setDamping(from.damping);
  to.setFrictionStatic(from.friction_static);
  to.setFrictionDynamic(from.friction_dynamic);
}

void fill(const haptic_shape& from, proto::Shape::Builder to) {
  to.setKind(static_cast<proto::ShapeKind>(from.kind));
  auto size = to.initSize();
  size.setX(from.size[0]);
  size.setY(from.size[1]);
  size.setZ(from.size[2]);
  to.setMesh(from.mesh);
}

void fill(const haptic_object& from, proto::ObjectSpec::Builder to) {
  to.setName(from.name);
  to.setParent(from.parent == nullptr ? "" : from.parent);
  fill(from.pose, to.initPose());
  fill(from.shape, to.initShape());
  fill(from.material, to.initMaterial());
  to.setEnabled((from.flags & HAPTIC_OBJECT_ENABLED) != 0);
  to.setVisible((from.flags & HAPTIC_OBJECT_VISIBLE) != 0);
  to.setTwoSided((from.flags & HAPTIC_OBJECT_TWO_SIDED) != 0);
  to.setKeep((from.flags & HAPTIC_OBJECT_KEEP) != 0);
}

}  // namespace hapticd::client
