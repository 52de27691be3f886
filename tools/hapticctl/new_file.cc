#include "tools/hapticctl/new_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/hapticctl/failure.h"

namespace hapticctl {

NewFile::NewFile(const std::string& path, bool replace) : path_(path) {
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (replace ? O_TRUNC : O_EXCL), 0644);
  if (fd_ >= 0) return;
  throw Failure{kExitFile, path, std::strerror(errno),
                errno == EEXIST ? "choose another name, or give --replace" : "choose a place where you may write"};
}

NewFile::~NewFile() {
  struct stat s {};
  const bool file = ::fstat(fd_, &s) == 0 && S_ISREG(s.st_mode);  // A device or a pipe was there before.
  ::close(fd_);
  if (bytes_ == 0 && file) ::unlink(path_.c_str());
}

int NewFile::write(const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = ::write(fd_, data, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    data += n;
    size -= static_cast<std::size_t>(n);
    bytes_ += static_cast<std::uint64_t>(n);
  }
  return 0;
}

int NewFile::sync() const { return ::fdatasync(fd_) == 0 || errno == EINVAL ? 0 : errno; }  // A pipe has none.

}  // namespace hapticctl
