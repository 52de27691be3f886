// How a device is set up, and who may: its limits, its point, its place in the world.
#include <fmt/format.h>

#include <algorithm>

#include "daemon/control/core.h"
#include "daemon/device/buttons.h"
#include "daemon/device/limits.h"
#include "daemon/device/mount.h"
#include "rt/render/proxy/proxy.h"

namespace hapticd {

Result<GuardLimits> Core::setLimits(std::string_view uri, const GuardLimits& wanted, std::uint64_t connection) {
  auto found = devices_.find(uri);
  if (!found) return found.error();
  OpenDevice& device = **found;
  auto merged = mergeLimits(device.limits, wanted);
  if (!merged) return merged;
  if (!raises(*merged, device.limits) && !raises(device.limits, *merged)) return *merged;  // It only asks.
  const Client& by = client(connection);
  const Session* holder = device.lease == 0 ? nullptr : sessions_.find(device.lease);
  const bool holds = holder != nullptr && holder->client.uid == by.uid;
  if (!by.administration && raises(*merged, device.limits)) {
    return Error{ErrorCode::kPermissionDenied, device.name, "raising limits needs the administration socket",
                 facts_.admin_socket.empty() ? "" : "connect to " + facts_.admin_socket};
  }
  if (!by.administration && !holds) {
    return Error{ErrorCode::kLeaseRequired, device.name,
                 "lowering limits is for the lease holder's user or administration", "acquire the lease first"};
  }
  if (auto r = checkMaxima(*merged, device.maxima, device.name); !r) return r.error();
  // What is lowered overtakes the edits that wait; what is raised comes after those that were to come first.
  const bool raised = raises(*merged, device.limits);
  if ((raised && !device.link->accepting()) || !device.link->lowerLimits(device.index, *merged)) {
    return Error{ErrorCode::kTimeout, device.name, "the servo takes no more orders now",
                 "try again; see hapticctl status"};
  }
  device.limits = *merged;
  if (raised)
    (void)device.link->post(makeCommand(CommandKind::kDeviceLimits, limitsOrder(device.index, *merged, false)));
  log::info("{}: limits {:g} N, {:g} N m, {:g} m/s by '{}' (pid {})", device.name, merged->force, merged->torque,
            merged->velocity, log::printable(by.name), by.pid);
  return *merged;
}

Result<void> Core::setRadius(OpenDevice& device, double radius, const Client& by) {
  if (!(radius >= 0 && radius <= ProxyRenderer::kMaxRadius)) {
    return Error{ErrorCode::kInvalidArgument, device.name,
                 fmt::format("a ball has a radius of 0 to {:g} m", ProxyRenderer::kMaxRadius), "for example 0.001"};
  }
  if (auto r = mayChange(device, by); !r) return r;
  device.radius = radius;
  device.applyRadius();
  return {};
}

Result<void> Core::setFinger(OpenDevice& device, const SetFinger& finger, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  device.wear(finger, device.info());
  device.applyFinger();
  return {};
}

bool Core::mayBeArmed(const OpenDevice& device) const {
  const std::string& uri = device.info().uri;
  const auto listed = std::ranges::find(listed_, uri, &Listed::uri);
  hd_sample sample;
  return listed != listed_.end() &&
         (!device.link->passed(listed->ticket) || !device.link->latest(device.index, sample) ||
          (sample.flags & HD_SAMPLE_ARMED) != 0);
}

/** Elsewhere, or of another size. */
Result<void> Core::mayBeSetUp(const OpenDevice& device, const std::string& where, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  if (!mayBeArmed(device)) return {};
  return Error{ErrorCode::kWouldBlock, where, "the device is armed, and its hand would jump",
               "disarm it and wait until its force is down"};
}

Result<void> Core::setMount(OpenDevice& device, const Pose& X_WD, const Client& by) {
  const std::string where = device.name + "/mount";
  if (!isFinite(X_WD.p) || !(X_WD.p.cwiseAbs().maxCoeff() <= Mount::kFarthest)) {
    return Error{ErrorCode::kInvalidArgument, where,
                 fmt::format("a place is within {:g} m of the world's origin, by axis", Mount::kFarthest),
                 "for example 0.3,0,0"};
  }
  const double norm = X_WD.q.norm();
  if (!(norm > 1e-6 && norm < 1e6)) {
    return Error{ErrorCode::kInvalidArgument, where, "the quaternion says no turn",
                 "w,x,y,z with a length near 1: 1,0,0,0 is none"};
  }
  if (auto r = mayBeSetUp(device, where, by); !r) return r;
  device.mount = Mount(Pose{X_WD.p, X_WD.q.normalized()}, device.mount.scale());
  device.applyMount();
  const Vec3 turns = toDegrees(device.mount.pose().q);
  log::info("{}: stands at {:g}, {:g}, {:g} m, turned by {:g}, {:g}, {:g} degrees", device.name, X_WD.p.x(), X_WD.p.y(),
            X_WD.p.z(), turns.x(), turns.y(), turns.z());
  return {};
}

Result<void> Core::setClutch(OpenDevice& device, bool held, std::uint32_t button, const Client& by) {
  if (button > 32) {
    return Error{ErrorCode::kInvalidArgument, device.name + "/clutch", fmt::format("there is no button {}", button),
                 "1 is the first; 0 binds none"};
  }
  const std::uint32_t there = buttonsOf(device.info(), &lines_);
  if (button > there && button != device.clutch_button) {
    return Error{ErrorCode::kInvalidArgument, device.name + "/clutch",
                 fmt::format("there is no button {}: it has {}", button, there), "1 is the first; 0 binds none"};
  }
  if (auto r = mayChange(device, by); !r) return r;
  device.clutch_held = held;
  device.clutch_button = button;
  device.applyClutch();
  return {};
}

Result<void> Core::setScale(OpenDevice& device, double scale, const Client& by) {
  const std::string where = device.name + "/scale";
  if (!Mount::validScale(scale)) {
    return Error{ErrorCode::kInvalidArgument, where,
                 fmt::format("a metre of the hand is {:g} to {:g} m of the world, not {:g}", Mount::kLeast,
                             Mount::kLargest, scale),
                 "make the scene larger or smaller; for example 5"};
  }
  if (auto r = mayBeSetUp(device, where, by); !r) return r;
  device.mount = Mount(device.mount.pose(), scale);
  device.applyScale();
  holdAnew(device);
  log::info("{}: a metre of the hand is {:g} m of the world{}", device.name, scale,
            device.info().max_stiffness > 0 ? fmt::format("; the stiffest surface that it bears has {:g} N/m there",
                                                          device.info().max_stiffness / scale)
                                            : std::string());
  return {};
}

}  // namespace hapticd
