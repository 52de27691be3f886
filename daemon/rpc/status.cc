#include "daemon/rpc/status.h"

#include <fmt/format.h>
#include <unistd.h>

#include "daemon/device/device_status.h"
#include "daemon/version.h"

namespace hapticd {
namespace {

void writeDevice(proto::DeviceState::Builder d, const OpenDevice& device, Core& core) {
  const DeviceNow status = statusOf(device);
  d.setUri(text(device.info().uri));
  d.setName(text(device.name));
  d.setArmed(status.armed);
  d.setFault(static_cast<std::uint16_t>(status.sample.fault));
  d.setFaultText(status.sample.fault == HD_FAULT_NONE ? "" : faultText(status.sample.fault));
  if (const Session* holder = device.lease == 0 ? nullptr : core.sessions().find(device.lease)) {
    d.setLeaseHolder(text(holder->client.name));
    d.setLeasePid(holder->client.pid);
  }
  d.setRateHz(status.rate_hz);
  d.setCycles(status.cycles);
  d.setMissed(status.missed);
  d.setStale(status.stale);
  d.setBusy(status.busy);
  d.setWakeP99Ns(static_cast<std::uint32_t>(std::min<std::uint64_t>(status.wake_p99_ns, UINT32_MAX)));
  write(d.initLimits(), device.limits);
  write(d.initPose(), Pose{vec3(status.sample.p), quat(status.sample.q)});
  write(d.initForce(), status.sample.force);
  d.setGroup(text(device.link->name()));
  d.setSchedulingPolicy(text(status.policy));
  d.setFlags(status.sample.flags);
  write(d.initVelocity(), status.sample.v);
  write(d.initTorque(), status.sample.torque);
  write(d.initProxy(), status.sample.proxy);
  d.setButtons(status.sample.buttons);
  d.setIndex(device.index);
}

void writeClient(proto::ClientState::Builder c, const Session& session) {
  const SessionNow status = statusOf(session);
  c.setSession(session.id);
  c.setName(text(session.client.name));
  c.setPid(session.client.pid);
  c.setUid(session.client.uid);
  c.setDevice(text(session.device->name));
  c.setLease(session.device->lease == session.id);
  c.setReceived(status.received);
  c.setRejected(status.rejected);
  c.setStale(status.stale);
  c.setModels(status.models);
  c.setFade(status.fade);
  c.setHeartbeatAgeNs(status.heartbeat_age_ns);
  c.setBytes(session.regions.bytes());
}

}  // namespace

void writeInfo(proto::DaemonInfo::Builder out, Core& core, bool administration) {
  out.setVersion(kVersion);
  out.setProtocolMajor(proto::PROTOCOL_MAJOR);
  out.setProtocolMinor(proto::PROTOCOL_MINOR);
  out.setEpoch(core.epoch());
  out.setPid(getpid());
  out.setAdministration(administration);
  out.setRealtime(core.devices().realtime());
  out.setSchedulingNote(text(core.devices().schedulingNote()));
  out.setSocket(text(administration ? core.facts().admin_socket : core.facts().control_socket));
  out.setConfigFile(text(core.facts().config_file));
  out.setStartedNs(core.started());
}

void writeState(proto::DaemonState::Builder out, Core& core, bool administration) {
  writeInfo(out.initInfo(), core, administration);
  const auto& devices = core.devices().devices();
  auto list = out.initDevices(static_cast<unsigned>(devices.size()));
  for (unsigned i = 0; i < devices.size(); ++i) writeDevice(list[i], *devices[i], core);
  std::vector<const Session*> sessions;
  for (const Session* session : core.sessions().all()) {
    if (core.sessions().find(session->id) != nullptr) sessions.push_back(session);
  }
  auto clients = out.initClients(static_cast<unsigned>(sessions.size()));
  for (unsigned i = 0; i < sessions.size(); ++i) writeClient(clients[i], *sessions[i]);
  out.setObjects(static_cast<std::uint32_t>(core.scene().size()));
  out.setTriangles(core.scene().triangles());
  out.setLockedBytes(core.lockedBytes());
  out.setUptimeNs(core.now() - core.started());
  out.setMeshes(static_cast<std::uint32_t>(core.meshes().list().size()));
}

void writeStatistics(proto::Statistics::Builder out, const OpenDevice& device) {
  Servo& servo = device.link->group().servo();
  out.setUri(text(device.info().uri));
  out.setPeriodNs(device.link->group().options().cycle.period_ns);
  out.setCycles(servo.counters.cycles.load(std::memory_order_relaxed));
  out.setMissed(servo.counters.missed.load(std::memory_order_relaxed));
  out.setOverruns(servo.counters.overruns.load(std::memory_order_relaxed));
  out.setStaleSamples(servo.counters.stale.load(std::memory_order_relaxed));
  const CollideNow collide = collideOf(device.link->group());
  out.setCollideQueries(collide.queries);
  out.setCollideExhausted(collide.exhausted);
  out.setCollideUnsent(collide.unsent);
  const auto stages = stagesOf(device.link->group());
  auto list = out.initHistograms(static_cast<unsigned>(stages.size()));
  for (unsigned i = 0; i < stages.size(); ++i) {
    const Histogram::Summary s = stages[i].histogram->summary();
    list[i].setName(stages[i].name);
    list[i].setCount(s.count);
    list[i].setP50Ns(s.p50_ns);
    list[i].setP99Ns(s.p99_ns);
    list[i].setP999Ns(s.p999_ns);
    list[i].setP9999Ns(s.p9999_ns);
    list[i].setMaxNs(s.max_ns);
  }
}

void resetStatistics(OpenDevice& device) {
  for (const Stage& stage : stagesOf(device.link->group())) stage.histogram->requestReset();
}

}  // namespace hapticd
