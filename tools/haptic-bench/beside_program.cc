#include "tools/haptic-bench/beside_program.h"

#include <filesystem>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

std::string besideProgram(std::initializer_list<const char*> paths) {
  std::error_code none;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
  for (const char* path : paths) {
    const auto candidate = (folder / path).lexically_normal();
    if (std::filesystem::exists(candidate, none)) return candidate.string();
  }
  return {};
}

std::string ownFile(const std::string& name) {
  std::string path = besideProgram({name.c_str(), ("../share/haptic-bench/" + name).c_str()});
  if (path.empty())
    throw Failure(name, "it lies neither beside the program nor where that is installed", "install it whole");
  return path;
}

}  // namespace haptic_bench
