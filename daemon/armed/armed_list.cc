#include "daemon/armed/armed_list.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>

namespace hapticd {
namespace {

/** Whether whoever opens `path` finds this file. */
bool isAt(int fd, const std::string& path) {
  struct stat held {
  }, there{};
  return ::fstat(fd, &held) == 0 && ::lstat(path.c_str(), &there) == 0 && held.st_dev == there.st_dev &&
         held.st_ino == there.st_ino;
}

Result<std::string> readAll(int fd, const std::string& path) {
  std::string text;
  std::array<char, 4096> piece;
  while (text.size() < ArmedList::kMostBytes) {
    const ssize_t n = ::pread(fd, piece.data(), piece.size(), static_cast<off_t>(text.size()));
    if (n < 0) return systemError(path, "read", errno);
    if (n == 0) break;
    text.append(piece.data(), static_cast<std::size_t>(n));
  }
  return text;
}

/** Those that say something, with where they begin. */
template <class F>
void forLines(std::string_view text, F&& f) {
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view line = text.substr(at, text.find('\n', at) - at);
    if (line.find_first_not_of(' ') != std::string_view::npos) f(line, static_cast<long>(at));
    at += line.size() + 1;
  }
}

Error tooLong(const std::string& path) {
  return {ErrorCode::kSystem, path,
          fmt::format("it has more than {} bytes, and nobody reads on", ArmedList::kMostBytes),
          "see who writes to it: a device that cannot be listed is not armed"};
}

}  // namespace

std::vector<std::string> armedIn(std::string_view text) {
  std::vector<std::string> uris;
  forLines(text, [&](std::string_view line, long) { uris.emplace_back(line); });
  return uris;
}

Result<UniqueFd> ArmedList::lock(const std::string& path) {
  UniqueFd file;
  for (int tries = 0; tries < 3; ++tries) {
    file.reset(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!file.valid())
      return systemError(path, "open", errno, unlessRunOut(errno, "its folder must be the daemon's own"));
    if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
      const int why = errno;
      if (why != EWOULDBLOCK) return systemError(path, "flock", why);
      return Error{ErrorCode::kDeviceBusy, path, "another process holds the list of armed devices",
                   "a hapticd that lives keeps its own devices; hapticctl stop"};
    }
    if (isAt(file.get(), path)) return file;  // Else somebody has removed it in between.
  }
  return Error{ErrorCode::kSystem, path, "somebody removes it as often as it is made", "see to its folder"};
}

Result<ArmedList> ArmedList::open(const std::string& path) {
  auto file = lock(path);
  if (!file) return file.error();
  ArmedList list;
  list.path_ = path;
  list.file_ = std::move(*file);
  auto text = readAll(list.file_.get(), path);
  if (!text) return text.error();
  list.text_ = std::move(*text);
  forLines(list.text_, [&](std::string_view line, long at) { list.left_.emplace(line, at); });
  // A line that a full disk cut short is not to grow by the next one.
  if (!list.text_.empty() && list.text_.back() != '\n') (void)list.writeAt(list.end(), "\n");
  return list;
}

ArmedList::~ArmedList() {
  if (left_.empty()) {
    clear();
    return;
  }
  std::vector<std::string> armed;
  for (const auto& [uri, at] : places_) armed.push_back(uri);
  for (const std::string& uri : armed) remove(uri);
}

std::vector<std::string> ArmedList::left() const {
  std::vector<std::pair<long, std::string>> all;
  for (const auto& [uri, at] : left_) all.emplace_back(at, uri);
  std::sort(all.begin(), all.end());
  std::vector<std::string> uris;
  for (auto& [at, uri] : all) {
    if (std::find(uris.begin(), uris.end(), uri) == uris.end()) uris.push_back(std::move(uri));
  }
  return uris;
}

bool ArmedList::writeAt(long offset, const std::string& text) {
  if (::pwrite(file_.get(), text.data(), text.size(), offset) != static_cast<ssize_t>(text.size())) return false;
  const auto at = static_cast<std::size_t>(offset);
  text_.resize(std::max(text_.size(), at + text.size()));
  text_.replace(at, text.size(), text);
  return true;
}

void ArmedList::settle(const std::string& uri) {
  const bool known = mend().ok();
  const auto [first, last] = left_.equal_range(uri);
  for (auto it = first; known && it != last; ++it) (void)writeAt(it->second, std::string(uri.size(), ' '));
  left_.erase(first, last);
}

void ArmedList::clear() {
  if (!file_.valid()) return;
  (void)!::ftruncate(file_.get(), 0);
  text_.clear();
  places_.clear();
  left_.clear();
}

Result<bool> ArmedList::keep() {
  if (!file_.valid()) return false;
  if (isAt(file_.get(), path_)) return mend();
  const std::string folder = path_.substr(0, path_.rfind('/') + 1);
  if (!folder.empty()) (void)::mkdir(folder.c_str(), 0700);  // As the socket's: open() tells what is wrong.
  auto file = lock(path_);
  if (!file) return file.error();
  auto there = readAll(file->get(), path_);  // Of another, who is dead: hapticd-safe looks after that, too.
  if (!there) return there.error();
  if (auto r = writeAnew(file->get(), std::move(*there), {}); !r) return r.error();
  file_ = std::move(*file);
  return true;
}

Result<bool> ArmedList::mend() {
  auto there = readAll(file_.get(), path_);
  if (!there) return there.error();
  if (*there == text_) return false;
  std::map<std::string, long> found;
  forLines(*there, [&](std::string_view line, long at) {
    if (has(std::string(line))) found.try_emplace(std::string(line), at);
  });
  if (auto r = writeAnew(file_.get(), std::move(*there), std::move(found)); !r) return r.error();
  return true;
}

Result<void> ArmedList::writeAnew(int file, std::string there, std::map<std::string, long> places) {
  std::multimap<std::string, long> left;
  forLines(there, [&](std::string_view line, long at) {
    const auto own = places.find(std::string(line));
    if (own == places.end() || own->second != at) left.emplace(line, at);
  });
  const std::size_t from = there.size();
  if (from > 0) there += '\n';
  for (const std::string& uri : this->left()) {
    if (left.count(uri) != 0) continue;
    left.emplace(uri, static_cast<long>(there.size()));
    there += uri + '\n';
  }
  for (const auto& [uri, before] : places_) {
    if (places.count(uri) != 0) continue;
    places[uri] = static_cast<long>(there.size());
    there += uri + '\n';
  }
  if (there.size() > kMostBytes) return tooLong(path_);
  const std::string more = there.substr(from);
  if (::pwrite(file, more.data(), more.size(), static_cast<off_t>(from)) != static_cast<ssize_t>(more.size())) {
    const int why = errno;
    (void)!::ftruncate(file, static_cast<off_t>(from));
    return systemError(path_, "write", why, "make room there");
  }
  text_ = std::move(there);
  places_ = std::move(places);
  left_ = std::move(left);
  return {};
}

Result<void> ArmedList::add(const std::string& uri) {
  if (!file_.valid()) return {};
  if (const auto kept = keep(); !kept) {  // Nobody would find it when we are dead.
    Error error = kept.error();
    error.remedy = "see to its folder: a device that cannot be listed is not armed";
    return error;
  }
  if (has(uri)) return {};
  const std::string line = uri + '\n';
  const long at = roomFor(line.size());
  if (static_cast<std::size_t>(at) + line.size() > kMostBytes) return tooLong(path_);
  text_.reserve(
      std::max(text_.size(), static_cast<std::size_t>(at) + line.size()));  // Once it stands there, it is known.
  const auto it = places_.emplace(uri, at).first;
  if (!writeAt(at, line)) {
    const int why = errno;
    // Half a line says nothing.
    (void)!::pwrite(file_.get(), text_.data() + at, std::min(line.size(), text_.size() - static_cast<std::size_t>(at)),
                    at);
    (void)!::ftruncate(file_.get(), end());
    places_.erase(it);
    return systemError(path_, "write", why,
                       "make room there, or see to that disk: a device that cannot be listed is not armed");
  }
  return {};
}

long ArmedList::roomFor(std::size_t bytes) const {
  std::size_t from = 0;  // Of the blank lines that end at `at`.
  for (std::size_t at = 0, end = 0; (end = text_.find('\n', at)) != std::string::npos;) {
    const bool blank = text_.find_first_not_of(' ', at) == end;
    at = end + 1;
    if (!blank) {
      from = at;
    } else if (at - from >= bytes) {
      return static_cast<long>(from);
    }
  }
  return end();
}

void ArmedList::remove(const std::string& uri) {
  const bool known = mend().ok();
  settle(uri);  // What has been switched off is at zero, whoever energised it.
  const auto it = places_.find(uri);
  if (it == places_.end()) return;
  // A line that cannot be taken back costs no more than a device that is brought to zero once more.
  if (known) (void)writeAt(it->second, std::string(uri.size(), ' ') + '\n');
  places_.erase(it);
}

bool ArmedList::has(const std::string& uri) const { return places_.count(uri) != 0; }

}  // namespace hapticd
