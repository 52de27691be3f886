#include "daemon/recording/convert.h"

#include <fmt/format.h>

#include <algorithm>

namespace hapticd {
namespace {

// What is not written here is not in the recording. Who changes one of these structs adds its fields to
// recording.capnp and to this file, and for an order raises ordersVersion unless the new fields stand last and zero
// means what was before.
static_assert(sizeof(AddObject) == 136 && sizeof(SetShape) == 40 && sizeof(SessionRef) == 16 &&
              sizeof(DeviceLimits) == 72 && sizeof(StopOrder) == 8 && sizeof(Command) == 512);
static_assert(sizeof(GuardLimits) == 64 && sizeof(GuardConfig) == 176);
static_assert(sizeof(DeviceSample) == 160 && sizeof(DeviceCommand) == 64);

constexpr std::int64_t kLongestPeriodNs = 1'000'000'000;
constexpr std::int64_t kMostTimeNs = std::int64_t{1} << 60;  ///< Thirty years.
constexpr std::size_t kMostOrders = 1u << 20;

template <class In>
std::string text(In in) {
  return {in.begin(), in.size()};
}

Error bad(std::string where, std::string what) {
  return {ErrorCode::kInvalidArgument, std::move(where), std::move(what), {}};
}

void write(const GuardLimits& in, proto::GuardLimits::Builder out) {
  out.setForce(in.force);
  out.setTorque(in.torque);
  out.setForceSlew(in.force_slew);
  out.setTorqueSlew(in.torque_slew);
  out.setGripperForce(in.gripper_force);
  out.setVelocity(in.velocity);
  out.setPower(in.power);
  out.setActivePower(in.active_power);
}

GuardLimits read(proto::GuardLimits::Reader in) {
  GuardLimits out;
  out.force = in.getForce();
  out.torque = in.getTorque();
  out.force_slew = in.getForceSlew();
  out.torque_slew = in.getTorqueSlew();
  out.gripper_force = in.getGripperForce();
  out.velocity = in.getVelocity();
  out.power = in.getPower();
  out.active_power = in.getActivePower();
  return out;
}

void write(const GuardConfig& in, proto::DeviceStart::Builder out) {
  write(in.limits, out.initLimits());
  out.setRampNs(in.ramp_ns);
  out.setSmallForce(in.small_force);
  out.setSmallTorque(in.small_torque);
  out.setSmallForceTicks(in.small_force_ticks);
  out.setStaleNs(in.stale_ns);
  out.setMissedLimit(in.missed_limit);
  out.setLifeNs(in.life_ns);
  out.setPassivity(in.passivity);
  out.setMaxDamping(in.max_damping);
  out.setEnergyLimit(in.energy_limit);
  out.setDelay(in.delay);
  out.setContinuousForce(in.continuous_force);
  out.setPeakForce(in.peak_force);
  out.setHeatingS(in.heating_s);
  out.setHeat(in.heat);
}

GuardConfig read(proto::DeviceStart::Reader in) {
  GuardConfig out;
  out.limits = read(in.getLimits());
  out.ramp_ns = in.getRampNs();
  out.small_force = in.getSmallForce();
  out.small_torque = in.getSmallTorque();
  out.small_force_ticks = in.getSmallForceTicks();
  out.stale_ns = in.getStaleNs();
  out.missed_limit = in.getMissedLimit();
  out.life_ns = in.getLifeNs();
  out.passivity = in.getPassivity();
  out.max_damping = in.getMaxDamping();
  out.energy_limit = in.getEnergyLimit();
  out.delay = in.getDelay();
  out.continuous_force = in.getContinuousForce();
  out.peak_force = in.getPeakForce();
  out.heating_s = in.getHeatingS();
  out.heat = in.getHeat();
  return out;
}

void write(const Command& in, proto::Order::Builder out) {
  out.setKind(static_cast<std::uint32_t>(in.kind));
  out.setSession(in.session);
  out.setSeq(in.seq);
  out.setAtTick(in.at_tick);
  out.setChannel(in.channel);
  std::size_t used = sizeof in.payload;
  while (used > 0 && in.payload[used - 1] == 0) --used;
  out.setPayload({in.payload, used});
}

bool credible(std::int64_t t_ns) { return t_ns >= -kMostTimeNs && t_ns <= kMostTimeNs; }

/** Sums and differences of times must not overflow; all else of a message the cycle checks itself. */
bool credibleTimes(const Command& command) {
  const auto both = [](const auto& model) { return credible(model.lease_ns) && credible(model.blend_ns); };
  switch (command.kind) {
    case CommandKind::kLocalModel:
      return both(command.as<hd_local_model>());
    case CommandKind::kForceField:
      return both(command.as<hd_force_field>());
    case CommandKind::kClearModel:
      return credible(command.as<hd_clear_model>().blend_ns);
    case CommandKind::kClientForce:
      return credible(command.as<hd_client_force>().lease_ns);
    default:
      return true;
  }
}

Result<void> read(proto::Order::Reader in, Command& out) {
  const auto payload = in.getPayload();
  if (payload.size() > sizeof out.payload) return bad("payload", fmt::format("it has {} bytes", payload.size()));
  out = Command{};
  out.kind = static_cast<CommandKind>(in.getKind());
  out.session = in.getSession();
  out.seq = in.getSeq();
  out.at_tick = in.getAtTick();
  out.channel = in.getChannel();
  std::copy(payload.begin(), payload.end(), out.payload);
  if (!credibleTimes(out)) return bad("payload", "its lease or blend is no time that a client can ask for");
  return {};
}

void write(const DeviceSample& in, const DeviceCommand& sent, proto::DeviceRecord::Builder out) {
  out.setTNs(in.t_ns);
  out.setPx(in.p.x());
  out.setPy(in.p.y());
  out.setPz(in.p.z());
  out.setQw(in.q.w());
  out.setQx(in.q.x());
  out.setQy(in.q.y());
  out.setQz(in.q.z());
  out.setVx(in.v.x());
  out.setVy(in.v.y());
  out.setVz(in.v.z());
  out.setWx(in.w.x());
  out.setWy(in.w.y());
  out.setWz(in.w.z());
  out.setGripperRad(in.gripper_rad);
  out.setGravityX(in.gravity.x());
  out.setGravityY(in.gravity.y());
  out.setGravityZ(in.gravity.z());
  out.setButtons(in.buttons);
  out.setStatus(in.status);
  out.setFresh(in.fresh);
  out.setHasVelocity(in.has_velocity);
  out.setEnabled(sent.enabled);
  out.setFx(sent.force.x());
  out.setFy(sent.force.y());
  out.setFz(sent.force.z());
  out.setTx(sent.torque.x());
  out.setTy(sent.torque.y());
  out.setTz(sent.torque.z());
  out.setGripperForce(sent.gripper_force);
}

void read(proto::DeviceRecord::Reader in, DeviceSample& out, DeviceCommand& sent) {
  out.t_ns = in.getTNs();
  out.p = {in.getPx(), in.getPy(), in.getPz()};
  out.q = {in.getQw(), in.getQx(), in.getQy(), in.getQz()};
  out.v = {in.getVx(), in.getVy(), in.getVz()};
  out.w = {in.getWx(), in.getWy(), in.getWz()};
  out.gripper_rad = in.getGripperRad();
  out.gravity = {in.getGravityX(), in.getGravityY(), in.getGravityZ()};
  out.buttons = in.getButtons();
  out.status = in.getStatus();
  out.fresh = in.getFresh();
  out.has_velocity = in.getHasVelocity();
  sent.enabled = in.getEnabled();
  sent.force = {in.getFx(), in.getFy(), in.getFz()};
  sent.torque = {in.getTx(), in.getTy(), in.getTz()};
  sent.gripper_force = in.getGripperForce();
}

Result<void> checkVersions(proto::Header::Reader in) {
  const auto refuse = [](const char* where, int theirs, int ours) {
    return Error{ErrorCode::kVersionMismatch, where, fmt::format("the recording has {}, this program {}", theirs, ours),
                 "use the version of hapticd that made the recording"};
  };
  if (in.getMajor() != proto::RECORDING_MAJOR) return refuse("major", in.getMajor(), proto::RECORDING_MAJOR);
  if (in.getOrders() != proto::ORDERS_VERSION) return refuse("orders", in.getOrders(), proto::ORDERS_VERSION);
  if (in.getLayoutMajor() != HD_SHM_MAJOR) return refuse("layoutMajor", in.getLayoutMajor(), HD_SHM_MAJOR);
  if (in.getLayoutMinor() > HD_SHM_MINOR) return refuse("layoutMinor", in.getLayoutMinor(), HD_SHM_MINOR);
  return {};
}

}  // namespace

void write(const RecordingHeader& header, proto::Header::Builder out) {
  out.setMajor(proto::RECORDING_MAJOR);
  out.setMinor(proto::RECORDING_MINOR);
  out.setOrders(proto::ORDERS_VERSION);
  out.setLayoutMajor(HD_SHM_MAJOR);
  out.setLayoutMinor(HD_SHM_MINOR);
  out.setProgram(header.program.c_str());
  out.setBuild(header.build.c_str());
  out.setInstructions(header.instructions.c_str());
  out.setStartedNs(header.started_ns);
  out.setFlushDenormals(header.flush_denormals);
  out.setGroup(header.group.c_str());
  const CycleStart& start = header.start;
  auto devices = out.initDevices(start.config.device_count);
  for (std::uint32_t d = 0; d < start.config.device_count; ++d) {
    write(start.config.guard[d], devices[d]);
    devices[d].setName(header.devices[d].name.c_str());
    devices[d].setUri(header.devices[d].uri.c_str());
    devices[d].setModel(header.devices[d].model.c_str());
    devices[d].setPositionResolution(start.resolution[d].position);
    devices[d].setRotationResolution(start.resolution[d].rotation);
  }
  out.setPeriodNs(start.config.period_ns);
  out.setLossFadeNs(start.config.loss_fade_ns);
  out.setTick(start.tick);
  out.setNowNs(start.now_ns);
  auto orders = out.initOrderList(static_cast<unsigned>(start.orders.size()));
  for (unsigned i = 0; i < orders.size(); ++i) write(start.orders[i], orders[i]);
  out.setMeshes(header.meshes);
}

void write(const RecordedCycle& cycle, std::uint32_t device_count, proto::CycleRecord::Builder out) {
  const CycleInput& input = cycle.input;
  out.setTick(input.tick);
  out.setNowNs(input.now_ns);
  out.setMissed(input.missed);
  out.setStopLine(input.stop_line);
  out.setDeadmanOpen(input.deadman_open);
  auto devices = out.initDevices(device_count);
  for (std::uint32_t d = 0; d < device_count; ++d) write(input.device[d], cycle.sent[d], devices[d]);
  if (input.command_count == 0) return;
  auto orders = out.initOrders(input.command_count);
  for (std::uint32_t i = 0; i < input.command_count; ++i) write(input.command[i], orders[i]);
}

Result<RecordingHeader> read(proto::Header::Reader in) {
  if (auto r = checkVersions(in); !r) return r.error();
  RecordingHeader out;
  out.program = text(in.getProgram());
  out.build = text(in.getBuild());
  out.instructions = text(in.getInstructions());
  out.started_ns = in.getStartedNs();
  out.flush_denormals = in.getFlushDenormals();
  out.group = text(in.getGroup());
  out.meshes = in.getMeshes();
  const auto devices = in.getDevices();
  if (devices.size() < 1 || devices.size() > kMaxDevices) {
    return bad("devices", fmt::format("there are {}, a group has 1 to {}", devices.size(), kMaxDevices));
  }
  if (in.getPeriodNs() <= 0 || in.getPeriodNs() > kLongestPeriodNs) {
    return bad("periodNs", fmt::format("it is {}", in.getPeriodNs()));
  }
  if (!credible(in.getNowNs()) || !credible(in.getLossFadeNs())) return bad("nowNs, lossFadeNs", "no credible times");
  CycleStart& start = out.start;
  start.config.device_count = devices.size();
  for (std::uint32_t d = 0; d < devices.size(); ++d) {
    start.config.guard[d] = read(devices[d]);
    if (!credible(devices[d].getRampNs()) || !credible(devices[d].getStaleNs())) {
      return bad(fmt::format("devices[{}].rampNs, staleNs", d), "no credible times");
    }
    start.resolution[d] = {devices[d].getPositionResolution(), devices[d].getRotationResolution()};
    out.devices.push_back({text(devices[d].getName()), text(devices[d].getUri()), text(devices[d].getModel())});
  }
  start.config.period_ns = in.getPeriodNs();
  start.config.loss_fade_ns = in.getLossFadeNs();
  start.tick = in.getTick();
  start.now_ns = in.getNowNs();
  const auto orders = in.getOrderList();
  if (orders.size() > kMostOrders) return bad("orderList", fmt::format("it has {} orders", orders.size()));
  start.orders.resize(orders.size());
  for (unsigned i = 0; i < orders.size(); ++i) {
    if (auto r = read(orders[i], start.orders[i]); !r) {
      return bad(fmt::format("orderList[{}].{}", i, r.error().where), r.error().what);
    }
  }
  return out;
}

Result<void> read(proto::CycleRecord::Reader in, std::uint32_t device_count, RecordedCycle& cycle) {
  CycleInput& input = cycle.input;
  input.tick = in.getTick();
  input.now_ns = in.getNowNs();
  input.missed = in.getMissed();
  input.stop_line = in.getStopLine();
  input.deadman_open = in.getDeadmanOpen();
  const auto devices = in.getDevices();
  if (devices.size() != device_count) {
    return bad(fmt::format("cycle of tick {}", input.tick),
               fmt::format("it has {} devices, the recording {}", devices.size(), device_count));
  }
  bool times = credible(input.now_ns);
  for (std::uint32_t d = 0; d < device_count; ++d) {
    read(devices[d], input.device[d], cycle.sent[d]);
    times = times && credible(input.device[d].t_ns);
  }
  if (!times) return bad(fmt::format("cycle of tick {}", input.tick), "its times are not credible");
  const auto orders = in.getOrders();
  if (orders.size() > kMaxCommandsPerCycle) {
    return bad(fmt::format("cycle of tick {}", input.tick), fmt::format("it has {} orders", orders.size()));
  }
  input.command_count = orders.size();
  for (unsigned i = 0; i < orders.size(); ++i) {
    if (auto r = read(orders[i], input.command[i]); !r) {
      return bad(fmt::format("cycle of tick {}, order {}, {}", input.tick, i, r.error().where), r.error().what);
    }
  }
  return {};
}

}  // namespace hapticd
