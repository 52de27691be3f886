#include "rt/cycle/cycle_start.h"

#include <algorithm>

namespace hapticd {

void restate(const Cycle& cycle, std::int64_t now_ns, std::vector<Command>& orders) {
  for (Command& order : orders) {  // What a session moves is to stand when that is lost.
    if (order.kind != CommandKind::kObjectPose) continue;
    auto& pose = order.as<hd_object_pose>();
    const std::uint32_t mover = cycle.scene().moverOf(pose.object);
    if (mover >= kMaxSessions) continue;
    const Twist& V = cycle.scene().find(pose.object)->V_PO;
    if (vec3(pose.v) != V.v || vec3(pose.w) != V.w) continue;  // Control has a newer one, of another's.
    pose.lease_us = cycle.scene().leaseOf(pose.object);
    order.session = mover;
    order.channel = 1;
  }
  for (std::uint32_t d = 0; d < cycle.config().device_count; ++d) {
    const std::uint32_t fault = cycle.deviceGuard(d).fault();
    if (fault != HD_FAULT_NONE) orders.push_back(makeCommand(CommandKind::kStop, StopOrder{d, fault}));
    const Mount& mount = cycle.mount(d);
    if (!mount.identity()) orders.push_back(makeCommand(CommandKind::kSetMount, mount.order(d)));
    const SetClutch clutch = cycle.clutch(d).order(d);  // After the mount, which would put its point elsewhere.
    if (clutch.held != 0 || clutch.button != 0 || clutch.frozen != 0)
      orders.push_back(makeCommand(CommandKind::kSetClutch, clutch));
    const double radius = cycle.deviceRadius(d);
    if (radius > 0) orders.push_back(makeCommand(CommandKind::kDeviceRadius, DeviceRadius{d, 0, radius}));
    if (cycle.grip(d).stiffness > 0) orders.push_back(makeCommand(CommandKind::kSetGrip, cycle.grip(d)));
    if (cycle.finger(d).soft()) orders.push_back(makeCommand(CommandKind::kSetFinger, cycle.finger(d).order()));
    if (cycle.tool(d).held()) orders.push_back(makeCommand(CommandKind::kAttachTool, cycle.tool(d).order()));
  }
  for (std::uint32_t slot = 0; slot < kMaxSessions; ++slot) {
    const SessionShare& session = cycle.session(slot);
    if (session.life() == SessionShare::Life::kFree) continue;
    orders.push_back(makeCommand(CommandKind::kAddSession, SessionRef{slot, 0, session.id()}));
    const std::size_t own = orders.size();
    session.restate(now_ns, orders);
    for (std::size_t i = own; i < orders.size(); ++i) orders[i].session = slot;
    if (session.life() == SessionShare::Life::kLost) {
      orders.push_back(makeCommand(CommandKind::kLoseSession, SessionRef{slot, 0, session.id()}));
    }
  }
  const auto pending = cycle.pending();
  orders.insert(orders.end(), pending.begin(), pending.end());
}

std::unique_ptr<Cycle> makeCycle(const CycleStart& start, const MeshTable& meshes) {
  auto cycle = std::make_unique<Cycle>(start.config, meshes);
  // Vertex motion is timed by the clock of the cycle before, which a replay has not seen: begin without any.
  for (std::uint32_t entry = 0; entry < kMaxMeshes; ++entry)
    if (MeshView* const mesh = meshes.get(entry)) forgetMotion(*mesh);
  for (std::uint32_t d = 0; d < start.config.device_count; ++d) {
    cycle->setResolution(d, start.resolution[d].position, start.resolution[d].rotation);
  }
  const auto input = std::make_unique<CycleInput>();
  const auto output = std::make_unique<CycleOutput>();
  input->tick = start.tick;
  input->now_ns = start.now_ns;
  for (std::size_t i = 0; i < start.orders.size(); i += input->command_count) {
    const std::size_t left = start.orders.size() - i;
    input->command_count = static_cast<std::uint32_t>(std::min<std::size_t>(left, kMaxCommandsPerCycle));
    std::copy_n(start.orders.begin() + static_cast<std::ptrdiff_t>(i), input->command_count, input->command.begin());
    cycle->applyCommands(*input, *output);
  }
  cycle->forgetEdits();
  return cycle;
}

}  // namespace hapticd
