#include "tools/hapticctl/file/whole_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "tools/hapticctl/file/new_file.h"
#include "tools/hapticctl/output/terminal.h"

namespace hapticctl {

WholeFile::WholeFile(const std::string& path, bool replace) : path_(path), replace_(replace) {
  struct stat old {};
  const bool there = ::stat(path.c_str(), &old) == 0;
  if (!replace && (there || ::lstat(path.c_str(), &old) == 0)) failMaking(path, EEXIST);
  if (there && !S_ISREG(old.st_mode)) {
    do {  // A signal may reach another thread: nothing here waits for long.
      fd_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
      if (fd_ < 0 && (errno != ENXIO || !S_ISFIFO(old.st_mode) || Interrupt::asked())) failMaking(path, errno);
      if (fd_ < 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));  // No reader yet.
    } while (fd_ < 0);
    return;
  }
  if (there && ::access(path.c_str(), W_OK) != 0)
    failMaking(path, errno);  // It is protected, though its folder is not.
  if (char real[PATH_MAX]; there && ::realpath(path.c_str(), real) != nullptr) path_ = real;  // A link stays one.
  for (int i = 0; fd_ < 0 && i < 100; ++i) {  // What a command that was killed has left stays.
    part_ = fmt::format("{}.{}.part", path_, i);
    fd_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (fd_ < 0 && errno != EEXIST) break;
  }
  if (fd_ < 0) failMaking(path, errno);
  if (there) (void)::fchmod(fd_, old.st_mode & 07777);
}

WholeFile::~WholeFile() {
  ::close(fd_);
  if (!part_.empty()) ::unlink(part_.c_str());
}

int WholeFile::write(const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = ::write(fd_, data, size);
    if (n < 0 && (errno == EAGAIN || errno == EINTR) && !Interrupt::asked()) {
      pollfd room{fd_, POLLOUT, 0};
      (void)::poll(&room, 1, 20);
      continue;
    }
    if (n < 0) return errno;
    data += n;
    size -= static_cast<std::size_t>(n);
    bytes_ += static_cast<std::uint64_t>(n);
  }
  return 0;
}

int WholeFile::keep() {
  if (part_.empty()) return 0;
  if (::fsync(fd_) != 0) return errno;
  int failed = replace_ ? ::rename(part_.c_str(), path_.c_str())
                        : ::renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE);
  if (failed == 0) {
    part_.clear();  // That name may be another command's by now.
    return 0;
  }
  if (errno == EINVAL) failed = ::link(part_.c_str(), path_.c_str());  // Not every file system can.
  return failed != 0 ? errno : 0;
}

}  // namespace hapticctl
