#include "drivers/vendor/sdk/sdk_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

namespace hapticd {

Result<SdkLibrary> SdkLibrary::open(const std::string& name, std::string_view remedy) {
  SdkLibrary library;
  library.name_ = name;
  // All symbols now: one that is missing must not be found out while force is on.
  library.handle_ = ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library.handle_ != nullptr) return library;
  const char* const why = ::dlerror();
  return Error{ErrorCode::kUnsupported, name, why == nullptr ? "cannot be loaded" : why, std::string(remedy)};
}

Result<void> SdkLibrary::complete(std::string_view wanted) const {
  if (missing_.empty()) return {};
  return Error{ErrorCode::kVersionMismatch, name_, fmt::format("it has no {}", fmt::join(missing_, ", ")),
               fmt::format("install {}", wanted)};
}

void* SdkLibrary::find(const char* symbol) const { return ::dlsym(handle_, symbol); }

std::string whereSdkIs(const std::string& name) {
  if (name.find('/') != std::string::npos) return ::access(name.c_str(), R_OK) == 0 ? name : std::string();
  for (const char* folder : {"/usr/local/lib", "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib",
                             "/usr/lib64", "/lib"}) {
    std::string path = fmt::format("{}/{}", folder, name);
    if (::access(path.c_str(), R_OK) == 0) return path;
  }
  return {};
}

}  // namespace hapticd
