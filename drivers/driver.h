/** @file
 * What a driver folder offers to the registry: one Driver, named once in the table of registry.cc.
 */
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "drivers/registry.h"

namespace hapticd {

/**
 * What brings a device to zero from a fresh process, when the daemon that armed it is dead: no state, no harm to a
 * device that is zero already, and less than the 1.8 seconds after which hapticd-safe ends it. Every driver says one:
 * there is no "none" by omission.
 */
class ZeroFunction {
 public:
  using Function = Result<void> (*)(const DeviceUri& uri);
  constexpr ZeroFunction(Function function) noexcept : function_(function) {}  // NOLINT(google-explicit-constructor)
  ZeroFunction(std::nullptr_t) = delete;
  Result<void> operator()(const DeviceUri& uri) const { return function_(uri); }

 private:
  Function function_;
};

/** The driver's word that no force outlives the process: it has none, or makes it in the process's own memory. */
inline Result<void> noForceOutlivesTheProcess(const DeviceUri&) { return {}; }

/** A family of devices behind one URI scheme. Plain functions: a table of these is all the registry holds. */
struct Driver {
  std::string_view scheme;
  std::string_view form;  ///< How its URIs look, for error messages.
  bool real = false;      ///< Hardware; the registry prefers it when no URI is given.
  /** Appends what is attached; opens nothing. */
  void (*find)(std::vector<DeviceFound>& found) = nullptr;
  /** Makes, but does not open, the device of that URI (its scheme is this driver's). */
  Result<std::unique_ptr<Device>> (*make)(const DeviceUri& uri) = nullptr;
  ZeroFunction zero;
};

}  // namespace hapticd
