#include "tools/hapticctl-import/hand_over.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>

#include "tools/hapticctl-import/image.h"
#include "tools/options/ending.h"

namespace hapticctl_import {
namespace {

constexpr std::array kEnds = {SIGINT, SIGTERM, SIGHUP};

char to_unlink[TemporaryFile::kMost][PATH_MAX];  // Empty: free.

extern "C" void unlinkAndEnd(int signal) {
  for (const auto& name : to_unlink)
    if (name[0] != '\0') ::unlink(name);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

std::atomic<pid_t> loading{0};  ///< hapticctl.

extern "C" void handOn(int signal) {
  if (const pid_t child = loading.load(); child > 0) ::kill(child, signal);
}

/** Signals that ask to end wait meanwhile. */
class EndsBlocked {
 public:
  EndsBlocked() {
    sigset_t ends;
    sigemptyset(&ends);
    for (const int end : kEnds) sigaddset(&ends, end);
    ::sigprocmask(SIG_BLOCK, &ends, &before_);
  }
  ~EndsBlocked() { ::sigprocmask(SIG_SETMASK, &before_, nullptr); }
  EndsBlocked(const EndsBlocked&) = delete;
  EndsBlocked& operator=(const EndsBlocked&) = delete;
  [[nodiscard]] const sigset_t& before() const { return before_; }

 private:
  sigset_t before_{};
};

/** What was in force is given to `before`; what is ignored stays so, as of nohup. */
void handleEnds(void (*handler)(int), std::array<void (*)(int), 3>& before) {
  for (std::size_t i = 0; i < kEnds.size(); ++i) {
    before[i] = ::signal(kEnds[i], handler);
    if (before[i] == SIG_IGN) ::signal(kEnds[i], SIG_IGN);
  }
}

ImportError notWritten(const std::string& path, int code) {
  return {path, std::string("cannot be written: ") + std::strerror(code),
          code == ENOSPC ? "make room, or choose another disk" : "choose another place for it"};
}

/** A name beside it to be made unique, no longer than a name may be. */
std::string besides(const std::filesystem::path& path) {
  constexpr std::string_view kUnique = ".XXXXXX";
  return (path.parent_path() / path.filename().string().substr(0, NAME_MAX - kUnique.size())).string().append(kUnique);
}

/** Whether it leads to a file by a descriptor that somebody has open, as /dev/stdout: he looks there, not at a name. */
bool isByDescriptor(std::filesystem::path path) {
  namespace fs = std::filesystem;
  constexpr int kMostLinks = 40;
  std::error_code none;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, none); ++i) {
    const fs::path folder = path.parent_path();
    if (fs::canonical(folder.empty() ? "." : folder, none).string().starts_with("/proc/")) return true;
    path = folder / fs::read_symlink(path, none);
  }
  return false;
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

TemporaryFile::TemporaryFile()
    : TemporaryFile((std::filesystem::temp_directory_path() / "hapticctl-import-XXXXXX.ply").string(), 4) {
  if (fd_ < 0) throw ImportError(path_, std::strerror(errno));
  ::close(fd_);
}

TemporaryFile::TemporaryFile(std::string pattern, int letters_behind) : path_(std::move(pattern)) {
  const EndsBlocked blocked;  // They find no file, or a file whose name is known.
  slot_ = 0;
  while (slot_ < kMost && to_unlink[slot_][0] != '\0') ++slot_;
  errno = ENAMETOOLONG;
  if (slot_ < kMost && path_.size() < PATH_MAX) fd_ = ::mkostemps(path_.data(), letters_behind, O_CLOEXEC);
  if (fd_ >= 0) {
    *std::copy(path_.begin(), path_.end(), to_unlink[slot_]) = '\0';
    handleEnds(unlinkAndEnd, before_);
  }
}

TemporaryFile::~TemporaryFile() {
  if (fd_ < 0) return;
  if (!path_.empty()) ::unlink(path_.c_str());
  to_unlink[slot_][0] = '\0';
  for (std::size_t i = 0; i < kEnds.size(); ++i) ::signal(kEnds[i], before_[i]);
}

int TemporaryFile::becomes(const std::string& path) {
  if (::rename(path_.c_str(), path.c_str()) != 0) return errno;
  path_.clear();
  return 0;
}

bool areOneFile(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code none;
  // Of a relative name whose first part is not there weakly_canonical() makes no absolute one, nor takes away "./".
  const auto whole = [&none](const std::string& path) { return fs::weakly_canonical(fs::absolute(path, none), none); };
  return fs::equivalent(a, b, none) || whole(a) == whole(b);
}

void requireWritable(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code none;
  if (fs::is_directory(path, none)) throw notWritten(path, EISDIR);
  const fs::path folder = fs::path(path).parent_path() / ".";  // So that a file in its place is told as one.
  const bool there = fs::exists(path, none);
  if (::access(there ? path.c_str() : folder.c_str(), there ? W_OK : W_OK | X_OK) != 0) throw notWritten(path, errno);
}

void requireEnding(const std::string& path, const std::string& ending) {
  if (hapticd_options::promisesAnother(path, ending))
    throw ImportError(path, "is no name for a " + ending + " file", "end it in " + ending);
}

void writeInPlace(const std::string& path, const std::string& bytes) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOCTTY, 0666);
  if (const int code = fd < 0 ? errno : writeAndClose(fd, bytes); code != 0) throw notWritten(path, code);
}

PreparedFile::PreparedFile(std::string path, std::string bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {
  namespace fs = std::filesystem;
  std::error_code none;
  if (fs::is_symlink(path_, none) && fs::is_regular_file(path_, none) && !isByDescriptor(path_)) {
    if (const fs::path whole = fs::canonical(path_, none); !none) path_ = whole.string();
  }
  const fs::file_status status = fs::symlink_status(path_, none);
  const bool there = fs::exists(status);
  if (there && !fs::is_regular_file(status)) return;
  if (part_.emplace(besides(path_)).fd() < 0) {
    const int code = errno;
    part_.reset();
    // A file in a folder that may not be written may be written still. For want of room it would lose what it held.
    if (code == EACCES || code == EPERM || code == EROFS) return;
    throw notWritten(path_, code);
  }
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(part_->fd(), there ? static_cast<mode_t>(status.permissions()) : 0666 & ~mask);
  if (const int code = writeAndClose(part_->fd(), bytes_); code != 0) throw notWritten(path_, code);
  bytes_ = {};
}

void PreparedFile::keep() {
  if (!part_) return writeInPlace(path_, bytes_);
  if (const int code = part_->becomes(path_); code != 0) throw notWritten(path_, code);
}

void writeFile(const std::string& path, const std::string& bytes) { PreparedFile(path, bytes).keep(); }

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
  std::array<void (*)(int), 3> before{};
  {
    const EndsBlocked blocked;  // They find none, or one whom they are handed on to.
    posix_spawnattr_t as_before;
    ::posix_spawnattr_init(&as_before);
    ::posix_spawnattr_setflags(&as_before, POSIX_SPAWN_SETSIGMASK);
    ::posix_spawnattr_setsigmask(&as_before, &blocked.before());
    pid_t child = 0;
    const int code = ::posix_spawnp(&child, program.c_str(), nullptr, &as_before, arguments.data(), environ);
    ::posix_spawnattr_destroy(&as_before);
    if (code != 0)
      throw ImportError("hapticctl", std::strerror(code), "install it, or write the surface with --output");
    loading = child;
    handleEnds(handOn, before);
  }
  siginfo_t ended{};
  while (::waitid(P_PID, static_cast<id_t>(loading), &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR) {
  }
  const pid_t child = loading.exchange(0);  // Until it is taken note of, its number is nobody else's.
  int status = 0;
  ::waitpid(child, &status, 0);
  for (std::size_t i = 0; i < kEnds.size(); ++i) ::signal(kEnds[i], before[i]);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace hapticctl_import
