/** @file
 * Answers of the daemon as JSON: the names of the C interface, vectors as arrays, units in the names where not SI.
 */
#pragma once

#include <hapticclient/hapticclient.h>

#include <nlohmann/json.hpp>

namespace hapticctl {

/** JSON that keeps the order in which it was written. */
using Json = nlohmann::ordered_json;

[[nodiscard]] Json toJson(const haptic_daemon_info& info);
[[nodiscard]] Json toJson(const haptic_device_info& device);
[[nodiscard]] Json toJson(const haptic_device_limits& limits);
[[nodiscard]] Json toJson(const haptic_device_status& device);
[[nodiscard]] Json toJson(const haptic_client_status& client);
[[nodiscard]] Json toJson(const haptic_status& status);
[[nodiscard]] Json toJson(const haptic_statistics& statistics);
[[nodiscard]] Json toJson(const haptic_sample& sample);
[[nodiscard]] Json toJson(const haptic_event& event);
[[nodiscard]] Json toJson(const haptic_mesh_report& report);
[[nodiscard]] Json toJson(const haptic_pose& pose);

}  // namespace hapticctl
