#include "drivers/pose_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstring>

#include "drivers/run_out.h"

namespace hapticd {

struct OpenedFile {
  OpenedFile(const std::string& path, int how) : fd(::open(path.c_str(), how | O_CLOEXEC | O_NOCTTY)) {}
  ~OpenedFile() {
    if (fd >= 0) ::close(fd);
  }
  OpenedFile(const OpenedFile&) = delete;
  OpenedFile& operator=(const OpenedFile&) = delete;

  const int fd;
};

namespace {

Error systemFault(const std::string& path, int number) {
  const bool missing = number == ENOENT || number == ENOTDIR;
  const char* const for_want = remedyForWant(number);
  return {missing ? ErrorCode::kNotFound : ErrorCode::kSystem, path, std::strerror(number),
          missing               ? "give the path as the daemon sees it"
          : for_want != nullptr ? for_want
                                : "the daemon's user must be able to read it"};
}

Error notAFile(const std::string& path) {
  return {ErrorCode::kInvalidArgument, path, "not a regular file", "give a CSV file"};
}

std::string kernelName(const OpenedFile& file) { return fmt::format("/proc/self/fd/{}", file.fd); }

/** Where the kernel has it, without a link on the way; empty if it does not say. */
std::string placeOf(const OpenedFile& file) {
  std::string place(PATH_MAX, '\0');
  const ssize_t size = file.fd < 0 ? -1 : ::readlink(kernelName(file).c_str(), place.data(), place.size());
  place.resize(size < 0 || size == PATH_MAX ? 0 : static_cast<std::size_t>(size));
  return place;
}

bool liesIn(const OpenedFile& file, const std::string& folder) {
  std::string outer = placeOf(OpenedFile(folder, O_PATH | O_DIRECTORY));
  if (outer.empty()) return false;
  if (outer.back() != '/') outer += '/';
  return placeOf(file).starts_with(outer);
}

/** Which goes up from somewhere, and so would tell whether that is there. */
bool goesUp(const std::string& path) { return ('/' + path + '/').find("/../") != std::string::npos; }

/** Whether the folder has no such name, not even that of a link which leads nowhere. */
bool isMissingIn(const std::string& path, const std::string& folder) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return false;
  const OpenedFile parent(path.substr(0, slash + 1), O_PATH | O_DIRECTORY);
  const std::string place = placeOf(parent), outer = placeOf(OpenedFile(folder, O_PATH | O_DIRECTORY));
  if (outer.empty() || (place != outer && !place.starts_with(outer == "/" ? outer : outer + '/'))) return false;
  struct stat there {};
  return ::fstatat(parent.fd, path.c_str() + slash + 1, &there, AT_SYMLINK_NOFOLLOW) != 0 && errno == ENOENT;
}

}  // namespace

Result<PoseFile> PoseFile::open(const std::string& path, const std::string& within) {
  // One answer for all that lies elsewhere: what there is, and what not, is nobody's business who may not name it.
  const auto mayNotBeNamed = [&] {
    return Error{ErrorCode::kPermissionDenied, path, "which files the daemon reads is the administrator's choice",
                 "put the file itself into " + within + ", and name it without '..'"};
  };
  if (!within.empty() && goesUp(path)) return mayNotBeNamed();
  // First a name for it that stays: what the path leads to may change between two looks, or be a FIFO that waits.
  const OpenedFile named(path, O_PATH);
  struct stat status {};
  const int why = named.fd < 0 || ::fstat(named.fd, &status) != 0 ? errno : 0;
  if (remedyForWant(why) != nullptr) return systemFault(path, why);
  if (!within.empty() && !(why == 0 ? liesIn(named, within) : why == ENOENT && isMissingIn(path, within)))
    return mayNotBeNamed();
  if (why != 0) return systemFault(path, why);
  if (!S_ISREG(status.st_mode)) return notAFile(path);
  PoseFile file;
  // Not to wait for whoever has a lease on it.
  file.file_ = std::make_shared<const OpenedFile>(kernelName(named), O_RDONLY | O_NONBLOCK);
  if (file.file_->fd < 0) return systemFault(path, errno);
  if (static_cast<std::uint64_t>(status.st_size) > PoseTrack::kMaxFileBytes) {
    return Error{ErrorCode::kQuotaExceeded, path,
                 fmt::format("{} bytes, more than the {} a motion may have", status.st_size, PoseTrack::kMaxFileBytes),
                 "split the file or thin it out"};
  }
  file.bytes_ = static_cast<std::size_t>(status.st_size);
  file.path_ = path;
  return file;
}

Result<std::shared_ptr<const PoseTrack>> PoseFile::read(const std::atomic<bool>& given_up) const {
  std::string text(bytes_, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t n = ::pread(file_->fd, text.data() + size, text.size() - size, static_cast<off_t>(size));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return systemFault(path_, errno);
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
  }
  text.resize(size);
  return parsePoseCsv(text, path_, &given_up);
}

}  // namespace hapticd
