/** @file
 * Keys of dhd:// and openhaptics:// URIs, and the devices they make.
 */
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/parameters.h"
#include "drivers/registry.h"

namespace hapticd {

inline constexpr std::string_view kDhdLibrary = "libdhd.so.3";
inline constexpr std::string_view kHdLibrary = "libHD.so";

struct DhdParameters {
  std::string sdk{kDhdLibrary};
  std::uint64_t serial = 0;
  bool gravity = false;
};
[[nodiscard]] const std::vector<Parameter<DhdParameters>>& dhdParameterTable();

struct DhdSetup {
  DhdParameters parameters;
  int index = -1;   ///< As the SDK counts; -1: the first.
  DeviceInfo info;  ///< Figures of a cautious unknown device, until it is open.
};
/** kInvalidArgument for a key, or a place that is no number. The SDK need not be there yet. */
[[nodiscard]] Result<DhdSetup> resolveDhd(const DeviceUri& uri);
/** Fills in what is published of that system type. */
void describeDhd(int system_type, DeviceInfo& info);

struct HdParameters {
  std::string sdk{kHdLibrary};
};
[[nodiscard]] const std::vector<Parameter<HdParameters>>& hdParameterTable();

struct HdSetup {
  HdParameters parameters;
  std::string device;  ///< As OpenHaptics' own set-up calls it; "": its default.
  DeviceInfo info;
};
[[nodiscard]] Result<HdSetup> resolveHd(const DeviceUri& uri);

}  // namespace hapticd
