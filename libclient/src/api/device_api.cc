// device.h: what answers with no reply of its own.
#include <cmath>

#include "libclient/src/api/call.h"
#include "libclient/src/reply/convert.h"

using hapticd::client::Failure;
using hapticd::client::Link;
namespace client = hapticd::client;

extern "C" {

int haptic_device_close(haptic_client* c, const char* uri, haptic_error* error) {
  if (uri == nullptr) return client::refuse(error, "uri", "is null");
  return client::order(c, error, [&](Link& link) {
    auto request = link.daemon.closeDeviceRequest();
    request.setUri(uri);
    return request;
  });
}

int haptic_stop(haptic_client* c, const char* uri, haptic_error* error) {
  return client::order(c, error, [&](Link& link) {
    auto request = link.daemon.stopRequest();
    request.setUri(client::orEmpty(uri));
    return request;
  });
}

int haptic_device_set_limits(haptic_client* c, const char* uri, const haptic_device_limits* limits,
                             haptic_device_limits* in_force, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    haptic_device_limits wanted{};
    for (double* limit : {&wanted.force, &wanted.torque, &wanted.force_slew, &wanted.torque_slew, &wanted.velocity,
                          &wanted.power, &wanted.active_power, &wanted.gripper_force}) {
      *limit = NAN;  // the daemon keeps what is NaN
    }
    const std::size_t minimum = offsetof(haptic_device_limits, torque);
    if (Failure bad = client::readSized(limits, wanted, minimum, "haptic_device_limits")) return bad;
    if (Failure bad = client::checkReserved(wanted.reserved, "haptic_device_limits.reserved")) return bad;
    if (in_force != nullptr) {  // Else a refusal of it would come when the limits are others already.
      if (Failure bad = client::checkSized(in_force, "haptic_device_limits")) return bad;
    }
    haptic_device_limits now{};
    const auto make = [&](Link& link) {
      auto request = link.daemon.setLimitsRequest();
      request.setUri(client::orEmpty(uri));
      client::fill(wanted, request.initLimits());
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
