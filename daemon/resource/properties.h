/** @file
 * The tables of what an object and a device have: one row a property.
 */
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "daemon/control/core.h"
#include "daemon/device/device_status.h"

namespace hapticd {

/** Of /objects/C. */
struct ObjectProperty {
  const char* name;
  const char* doc;
  nlohmann::json (*get)(const ObjectNow& object, Core& core);
  /** Null: read-only. `where` is for errors. */
  Result<void> (*set)(Core& core, const ObjectNow& object, std::string_view value, const std::string& where);
};
[[nodiscard]] std::span<const ObjectProperty> objectProperties();

/** Of /devices/NAME. Nearly all read-only: limits are set by setLimits, arming by the lease. */
struct DeviceProperty {
  const char* name;
  const char* doc;
  nlohmann::json (*get)(const OpenDevice& device, const DeviceNow& status, Core& core);
  /** Null: read-only. `where` is for errors. */
  Result<void> (*set)(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                      const Client& by) = nullptr;
};
[[nodiscard]] std::span<const DeviceProperty> deviceProperties();

[[nodiscard]] nlohmann::json toJson(const Vec3& x);
[[nodiscard]] nlohmann::json toJson(const Quat& q);  ///< w, x, y, z
[[nodiscard]] nlohmann::json toJson(const Pose& pose);
[[nodiscard]] nlohmann::json toJson(const hd_material& material);
[[nodiscard]] nlohmann::json toJson(const GuardLimits& limits);
[[nodiscard]] nlohmann::json toJson(const MeshInfo& mesh);
[[nodiscard]] nlohmann::json toJson(const TextureInfo& texture);
/** A number; null where it is not finite, which JSON cannot say. */
[[nodiscard]] nlohmann::json number(double x);

}  // namespace hapticd
