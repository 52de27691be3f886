#include "tools/hapticctl-import/hand_over.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {
namespace {

constexpr int kEnds[] = {SIGINT, SIGTERM, SIGHUP};

char to_unlink[PATH_MAX];

extern "C" void unlinkAndEnd(int signal) {
  ::unlink(to_unlink);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

ImportError notWritten(const std::string& path, int code) {
  return {path, std::string("cannot be written: ") + std::strerror(code),
          code == ENOSPC ? "make room, or choose another disk" : "choose another place for it"};
}

/** 0, or what went wrong. */
int writeAndClose(int fd, std::string_view bytes) {
  int code = 0;
  while (code == 0 && !bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno != EINTR) code = errno;
    if (n == 0) code = EIO;
    if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  const int closed = ::close(fd) != 0 ? errno : 0;
  return code != 0 ? code : closed;
}

}  // namespace

TemporaryFile::TemporaryFile() {
  path_ = (std::filesystem::temp_directory_path() / "hapticctl-import-XXXXXX.ply").string();
  const int fd = ::mkstemps(path_.data(), 4);
  if (fd < 0) throw ImportError(path_, std::strerror(errno));
  ::close(fd);
  path_.copy(to_unlink, sizeof to_unlink - 1);
  for (const int end : kEnds) ::signal(end, unlinkAndEnd);
}

TemporaryFile::~TemporaryFile() {
  for (const int end : kEnds) ::signal(end, SIG_DFL);
  ::unlink(path_.c_str());
}

void requireWritable(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code none;
  if (fs::is_directory(path, none)) throw notWritten(path, EISDIR);
  const fs::path folder = fs::path(path).parent_path() / ".";  // So that a file in its place is told as one.
  const bool there = fs::exists(path, none);
  if (::access(there ? path.c_str() : folder.c_str(), there ? W_OK : W_OK | X_OK) != 0) throw notWritten(path, errno);
}

void writeInPlace(const std::string& path, const std::string& bytes) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOCTTY, 0666);
  if (const int code = fd < 0 ? errno : writeAndClose(fd, bytes); code != 0) throw notWritten(path, code);
}

void writeFile(const std::string& path, const std::string& bytes) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::file_status status = fs::symlink_status(path, none);
  const bool there = fs::exists(status);
  std::string part = path + ".XXXXXX";
  const int fd = !there || fs::is_regular_file(status) ? ::mkostemp(part.data(), O_CLOEXEC) : -1;
  if (fd < 0) return writeInPlace(path, bytes);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(fd, there ? static_cast<mode_t>(status.permissions()) : 0666 & ~mask);
  int code = writeAndClose(fd, bytes);
  if (code == 0 && ::rename(part.c_str(), path.c_str()) != 0) code = errno;
  if (code == 0) return;
  ::unlink(part.c_str());
  throw notWritten(path, code);
}

void requireSaid() {
  if (std::fflush(stdout) == 0 || errno == EPIPE) return;
  throw ImportError("standard output", std::strerror(errno), "make room where it goes");
}

int runHapticctl(const std::vector<std::string>& words) {
  char self[PATH_MAX];
  const ssize_t size = ::readlink("/proc/self/exe", self, sizeof self);
  std::filesystem::path program =
      std::filesystem::path(std::string(self, size > 0 ? static_cast<std::size_t>(size) : 0)).parent_path() /
      "hapticctl";
  if (const char* const caller = std::getenv("HAPTICCTL")) program = caller;
  if (::access(program.c_str(), X_OK) != 0) program = "hapticctl";
  std::vector<char*> arguments;
  arguments.reserve(words.size());
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (const int code = ::posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ); code != 0)
    throw ImportError("hapticctl", std::strerror(code), "install it, or write the surface with --output");
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace hapticctl_import
