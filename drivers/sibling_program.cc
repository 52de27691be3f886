#include "drivers/sibling_program.h"

#include <unistd.h>

#include <climits>
#include <string_view>
#include <vector>

namespace hapticd {

Result<std::string> findSibling(const std::string& name, const std::string& configured, const char* remedy) {
  std::vector<std::string> candidates;
  if (!configured.empty()) {
    candidates.push_back(configured);
  } else {
    char self[PATH_MAX];
    const ssize_t size = ::readlink("/proc/self/exe", self, sizeof self);
    const std::string_view path(self, size > 0 ? static_cast<std::size_t>(size) : 0);
    const std::string folder(path.substr(0, path.rfind('/') + 1));
    candidates.push_back(folder + name);
    candidates.push_back(folder + HAPTICD_LIBEXEC_FROM_PROGRAM "/" + name);
  }
  std::string tried;
  for (const std::string& candidate : candidates) {
    if (::access(candidate.c_str(), X_OK) == 0) return candidate;
    tried += (tried.empty() ? "" : " and ") + candidate;
  }
  return Error{ErrorCode::kNotFound, name, "not found at " + tried, remedy};
}

}  // namespace hapticd
