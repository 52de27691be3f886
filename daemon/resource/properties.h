/** @file
 * The tables of what an object and a device have: one row a property.
 */
#pragma once

#include <span>
#include <string_view>

#include "daemon/control/core.h"
#include "daemon/device/device_status.h"
#include "daemon/resource/json.h"

namespace hapticd {

/** Of /objects/C. */
struct ObjectProperty {
  const char* name;
  const char* doc;
  Json (*get)(const ObjectNow& object, Core& core);
  /** Null: read-only. `where` is for errors. */
  Result<void> (*set)(Core& core, const ObjectNow& object, std::string_view value, const std::string& where);
};
[[nodiscard]] std::span<const ObjectProperty> objectProperties();

/** Of /devices/NAME. Nearly all read-only: limits are set by setLimits, arming by the lease. */
struct DeviceProperty {
  const char* name;
  const char* doc;
  Json (*get)(const OpenDevice& device, const DeviceNow& status, Core& core);
  /** Null: read-only. `where` is for errors. */
  Result<void> (*set)(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                      const Client& by) = nullptr;
};
[[nodiscard]] std::span<const DeviceProperty> deviceProperties();

[[nodiscard]] Json toJson(const Vec3& x);
[[nodiscard]] Json toJson(const Quat& q);  ///< w, x, y, z
[[nodiscard]] Json toJson(const Pose& pose);
[[nodiscard]] Json toJson(const hd_material& material);
[[nodiscard]] Json toJson(const GuardLimits& limits);
[[nodiscard]] Json toJson(const MeshInfo& mesh);
[[nodiscard]] Json toJson(const TextureInfo& texture);
/** A number; null where it is not finite, which JSON cannot say. */
[[nodiscard]] Json number(double x);

}  // namespace hapticd
