// device.h: what answers with no reply of its own.
#include <cmath>

#include "libclient/src/convert.h"
#include "libclient/src/loop.h"

using hapticd::client::Failure;
using hapticd::client::Link;
namespace client = hapticd::client;

namespace {

constexpr double haptic_device_limits::*kLimits[] = {
    &haptic_device_limits::force,       &haptic_device_limits::torque,   &haptic_device_limits::force_slew,
    &haptic_device_limits::torque_slew, &haptic_device_limits::velocity, &haptic_device_limits::power,
    &haptic_device_limits::active_power};

/** Puts the limits in force where the caller left NaN. */
Failure fillKept(haptic_client* c, const char* uri, haptic_device_limits& limits) {
  bool kept = false;
  for (const auto limit : kLimits) kept = kept || std::isnan(limits.*limit);
  if (!kept) return {};
  bool found = false;
  const std::string_view wanted = uri == nullptr ? "" : uri;
  std::string canonical;
  // The state names devices by URI and name; a serial number is resolved by opening, which changes nothing.
  const auto open = [&](Link& link) {
    auto request = link.daemon.openDeviceRequest();
    request.setUri(std::string(wanted).c_str());
    return request;
  };
  if (Failure failure = client::callDaemon(*c->connection, open,
                                           [&](auto& results) { canonical = results.getDevice().getUri().cStr(); })) {
    return failure;
  }
  if (Failure failure = client::callDaemon(
          *c->connection, [](Link& link) { return link.daemon.stateRequest(); },
          [&](auto& results) {
            for (const auto device : results.getState().getDevices()) {
              if (found || canonical != device.getUri().cStr()) continue;
              found = true;
              const haptic_device_limits now = client::convert(device.getLimits());
              for (const auto limit : kLimits) {
                if (std::isnan(limits.*limit)) limits.*limit = now.*limit;
              }
            }
          })) {
    return failure;
  }
  if (found) return {};
  return {HAPTIC_NOT_FOUND, std::string(wanted), "no open device of that name", "see hapticctl list"};
}

}  // namespace

extern "C" {

int haptic_close_device(haptic_client* c, const char* uri, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (uri == nullptr) return client::badArgument("uri", "is null");
    return client::callDaemon(*c->connection, [&](Link& link) {
      auto request = link.daemon.closeDeviceRequest();
      request.setUri(uri);
      return request;
    });
  });
}

int haptic_stop(haptic_client* c, const char* uri, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    return client::callDaemon(*c->connection, [&](Link& link) {
      auto request = link.daemon.stopRequest();
      request.setUri(uri == nullptr ? "" : uri);
      return request;
    });
  });
}

int haptic_set_limits(haptic_client* c, const char* uri, const haptic_device_limits* limits,
                      haptic_device_limits* in_force, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    haptic_device_limits wanted{};
    for (const auto limit : kLimits) wanted.*limit = NAN;
    const std::size_t minimum = offsetof(haptic_device_limits, torque);
    if (Failure bad = client::readSized(limits, wanted, minimum, "haptic_device_limits")) return bad;
    if (Failure failure = fillKept(c, uri, wanted)) return failure;
    haptic_device_limits now{};
    const auto make = [&](Link& link) {
      auto request = link.daemon.setLimitsRequest();
      request.setUri(uri == nullptr ? "" : uri);
      client::convert(wanted, request.initLimits());
      return request;
    };
    if (Failure failure = client::callDaemon(*c->connection, make,
                                             [&](auto& results) { now = client::convert(results.getLimits()); })) {
      return failure;
    }
    return in_force == nullptr ? Failure{} : client::writeSized(now, in_force, "haptic_device_limits");
  });
}

}  // extern "C"
