#include "tools/hapticctl/external.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "rt/base/edit_distance.h"

namespace hapticctl {

std::string findExternal(std::string_view name) {
  // A word of the command line becomes part of a path: only plain words may.
  if (name.empty() || name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") != std::string_view::npos)
    return {};
  const std::string program = "hapticctl-" + std::string(name);
  std::vector<std::filesystem::path> places;
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    places.push_back(self.parent_path());
    places.push_back(self.parent_path().parent_path() / program);  // As they lie where they are built.
    places.push_back(self.parent_path().parent_path() / "libexec/hapticd");
  }
  if (const char* path = std::getenv("PATH")) {
    for (std::string_view rest = path; !rest.empty();) {
      const std::size_t colon = std::min(rest.find(':'), rest.size());
      if (colon > 0) places.emplace_back(rest.substr(0, colon));
      rest.remove_prefix(std::min(colon + 1, rest.size()));
    }
  }
  for (const auto& place : places) {
    const auto candidate = place / program;
    if (std::filesystem::is_regular_file(candidate, error) && access(candidate.c_str(), X_OK) == 0)
      return candidate.string();
  }
  return {};
}

void runExternal(const std::string& program, int argc, char** argv, int word, bool hands_on) {
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (int i = word + 1; i < argc; ++i) arguments.push_back(argv[i]);
  for (int i = 1; i < word; ++i) {
    const std::string_view option = argv[i];
    constexpr std::string_view kSocket = "--socket";
    if (option == kSocket) {
      setenv("HAPTICD_SOCKET", argv[++i], 1);
    } else if (option.starts_with(kSocket) && option[kSocket.size()] == '=') {
      setenv("HAPTICD_SOCKET", argv[i] + kSocket.size() + 1, 1);
    } else if (hands_on) {
      arguments.push_back(argv[i]);
      if (option == "--timeout") arguments.push_back(argv[++i]);
    }
  }
  arguments.push_back(nullptr);
  std::error_code error;
  if (const auto self = std::filesystem::read_symlink("/proc/self/exe", error); !error)
    setenv("HAPTICCTL", self.c_str(), 1);
  execv(program.c_str(), arguments.data());
}

std::vector<std::string> suggestions(std::string_view word, const std::vector<std::string>& known) {
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const std::string& candidate : known) {
    const bool begins = word.size() >= 2 && std::string_view(candidate).starts_with(word);
    const std::size_t d = begins ? 0 : hapticd::editDistance(word, candidate);
    if (begins || d <= std::max<std::size_t>(1, std::min(word.size(), candidate.size()) / 3))
      near.emplace_back(d, candidate);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::string> out;
  out.reserve(near.size());
  for (auto& [d, candidate] : near) out.push_back(std::move(candidate));
  return out;
}

}  // namespace hapticctl
