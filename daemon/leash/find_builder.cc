#include "daemon/leash/find_builder.h"

#include <unistd.h>

#include <climits>
#include <string_view>
#include <vector>

namespace hapticd {

Result<std::string> findBuilder(const std::string& configured) {
  std::vector<std::string> candidates;
  if (!configured.empty()) {
    candidates.push_back(configured);
  } else {
    char self[PATH_MAX];
    const ssize_t size = ::readlink("/proc/self/exe", self, sizeof self);
    const std::string_view path(self, size > 0 ? static_cast<std::size_t>(size) : 0);
    const std::string folder(path.substr(0, path.rfind('/') + 1));
    candidates.push_back(folder + "hapticd-builder");
    candidates.push_back(folder + HAPTICD_LIBEXEC_FROM_PROGRAM "/hapticd-builder");
  }
  std::string tried;
  for (const std::string& candidate : candidates) {
    if (::access(candidate.c_str(), X_OK) == 0) return candidate;
    tried += (tried.empty() ? "" : " and ") + candidate;
  }
  return Error{ErrorCode::kNotFound, "hapticd-builder", "not found at " + tried, "install it, or set builder.program"};
}

}  // namespace hapticd
