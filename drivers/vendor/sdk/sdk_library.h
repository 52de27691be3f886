/** @file
 * A vendor's closed library, loaded at run time: hapticd is built and shipped without it.
 */
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

/** Loads once and never unloads: such libraries leave threads and handlers behind. Only in hapticd-vendor and tests. */
class SdkLibrary {
 public:
  /** By path, or by name where the system's loader looks. kUnsupported when it is not there or cannot be loaded. */
  [[nodiscard]] static Result<SdkLibrary> open(const std::string& name, std::string_view remedy);

  /** Its function, or null, which is noted. */
  template <class Function>
  void need(Function*& function, const char* symbol) {
    function = reinterpret_cast<Function*>(find(symbol));
    if (function == nullptr) missing_.emplace_back(symbol);
  }
  /** kVersionMismatch that names what is missing, if anything is. */
  [[nodiscard]] Result<void> complete(std::string_view wanted) const;
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  [[nodiscard]] void* find(const char* symbol) const;
  std::string name_;
  void* handle_ = nullptr;
  std::vector<std::string> missing_;
};

/** The file that the system's loader would take for that name, by the usual folders; "" if there is none. Loads
 * nothing. */
[[nodiscard]] std::string whereSdkIs(const std::string& name);

}  // namespace hapticd
