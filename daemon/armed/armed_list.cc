#include "daemon/armed/armed_list.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>

namespace hapticd {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;  ///< A list is some hundred bytes.

bool writeAt(int fd, const std::string& text, long offset) {
  return ::pwrite(fd, text.data(), text.size(), offset) == static_cast<ssize_t>(text.size());
}

/** Whether whoever opens `path` finds this file. */
bool isAt(int fd, const std::string& path) {
  struct stat held {
  }, there{};
  return ::fstat(fd, &held) == 0 && ::lstat(path.c_str(), &there) == 0 && held.st_dev == there.st_dev &&
         held.st_ino == there.st_ino;
}

}  // namespace

std::vector<std::string> armedIn(std::string_view text) {
  std::vector<std::string> uris;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.find_first_not_of(' ') != std::string_view::npos) uris.emplace_back(line);
  }
  return uris;
}

Result<ArmedList> ArmedList::open(const std::string& path) {
  ArmedList list;
  list.path_ = path;
  list.file_.reset(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!list.file_.valid()) return systemError(path, "open", errno, "its folder must be the daemon's own");
  if (::flock(list.file_.get(), LOCK_EX | LOCK_NB) != 0) {
    const int why = errno;
    list.file_.reset();
    if (why != EWOULDBLOCK) return systemError(path, "flock", why);
    return Error{ErrorCode::kDeviceBusy, path, "another process holds the list of armed devices",
                 "a hapticd that lives keeps its own devices; hapticctl stop"};
  }
  std::string text;
  std::array<char, 4096> piece;
  while (text.size() < kMostBytes) {
    const ssize_t n = ::pread(list.file_.get(), piece.data(), piece.size(), static_cast<off_t>(text.size()));
    if (n < 0) return systemError(path, "read", errno);
    if (n == 0) break;
    text.append(piece.data(), static_cast<std::size_t>(n));
  }
  list.left_ = armedIn(text);
  list.end_ = static_cast<long>(text.size());
  // A line that a full disk cut short is not to grow by the next one.
  if (!text.empty() && text.back() != '\n' && writeAt(list.file_.get(), "\n", list.end_)) ++list.end_;
  return list;
}

ArmedList::~ArmedList() { clear(); }

void ArmedList::clear() {
  if (!file_.valid()) return;
  (void)!::ftruncate(file_.get(), 0);
  end_ = 0;
  places_.clear();
  left_.clear();
}

Result<void> ArmedList::add(const std::string& uri) {
  if (!file_.valid()) return {};
  const auto [it, fresh] = places_.try_emplace(uri, Place{end_, false});
  if (!isAt(file_.get(), path_)) {  // Nobody would find it when we are dead.
    if (fresh) places_.erase(it);
    return Error{ErrorCode::kSystem, path_, "the list of armed devices has been removed",
                 "start hapticd again: a device that cannot be listed is not armed"};
  }
  if (it->second.armed) return {};
  if (!writeAt(file_.get(), uri + '\n', it->second.offset)) {
    const int why = errno;
    if (fresh) {
      (void)!::ftruncate(file_.get(), end_);  // half a line says nothing
      places_.erase(it);
    }
    return systemError(path_, "write", why,
                       "make room there, or see to that disk: a device that cannot be listed is not armed");
  }
  if (fresh) end_ += static_cast<long>(uri.size()) + 1;
  it->second.armed = true;
  return {};
}

void ArmedList::remove(const std::string& uri) {
  const auto it = places_.find(uri);
  if (it == places_.end() || !it->second.armed) return;
  // A line that cannot be taken back costs no more than a device that is brought to zero once more.
  (void)writeAt(file_.get(), std::string(uri.size(), ' ') + '\n', it->second.offset);
  it->second.armed = false;
}

bool ArmedList::has(const std::string& uri) const {
  const auto it = places_.find(uri);
  return it != places_.end() && it->second.armed;
}

}  // namespace hapticd
