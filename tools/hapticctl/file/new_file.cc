#include "tools/hapticctl/file/new_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/hapticctl/failure.h"

namespace hapticctl {

NewFile::NewFile(const std::string& path, bool replace) : path_(path) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_CLOEXEC;
  fd_ = ::open(path.c_str(), kFlags | O_EXCL, 0644);
  if (fd_ < 0 && errno == EEXIST && replace) {
    before_ = true;
    fd_ = ::open(path.c_str(), kFlags, 0644);
  }
  struct stat s {};
  file_ = fd_ >= 0 && ::fstat(fd_, &s) == 0 && S_ISREG(s.st_mode);
  if (fd_ >= 0) return;
  failMaking(path, errno);
}

NewFile::~NewFile() {
  ::close(fd_);
  if (file_ && bytes_ == 0 && !before_) ::unlink(path_.c_str());
}

int NewFile::write(const char* data, std::size_t size) {
  if (before_ && size > 0) {
    if (file_ && ::ftruncate(fd_, 0) != 0) return errno;
    before_ = false;
  }
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

namespace {

const char* remedyOfMaking(int error) {
  switch (error) {
    case EEXIST:
      return "choose another name, or give --replace";
    case ENOENT:
      return "make its folder first, or name another";
    case ENOTDIR:
      return "what stands before its last / must be a folder";
    case ENAMETOOLONG:
      return "choose a shorter name";
    case ENOSPC:
    case EDQUOT:
      return "make room on the disk";
    case EMFILE:
    case ENFILE:
      return "raise the limit of open files (ulimit -n)";
    default:
      return "choose a place where you may write";
  }
}

const char* remedyOfWriting(int error) {
  switch (error) {
    case EFBIG:
      return "raise the limit of a file's size (ulimit -f)";
    case EPIPE:
      return "whoever read it has gone: begin again";
    case ENOSPC:
    case EDQUOT:
      return "make room on the disk";
    default:
      return "see whether its disk is well, or choose another";
  }
}

}  // namespace

void failMaking(const std::string& path, int error) {
  struct stat s {};
  if (::stat(path.c_str(), &s) == 0 && S_ISDIR(s.st_mode)) {
    throw Failure{kExitFile, path, "is a folder", "name a file in it"};
  }
  throw Failure{kExitFile, path, std::strerror(error), remedyOfMaking(error)};
}

void failWriting(const std::string& file, int error) {
  throw Failure{kExitFile, file, std::strerror(error), remedyOfWriting(error)};
}

}  // namespace hapticctl
