#include "daemon/rpc/listen_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <systemd/sd-daemon.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "daemon/config/config.h"

namespace hapticd {
namespace {

constexpr int kBacklog = 64;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

std::string folderOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

/** The default for what is not there; nothing where that cannot be seen. */
std::optional<FileId> lookAt(const std::string& path) {
  struct stat info {};
  if (lstat(path.c_str(), &info) == 0) return FileId{info.st_dev, info.st_ino};
  if (errno == ENOENT || errno == ENOTDIR) return FileId{};
  return std::nullopt;
}

FileId idAt(const std::string& path) { return lookAt(path).value_or(FileId{}); }

FileId idOf(int fd) {
  struct stat info {};
  return fstat(fd, &info) == 0 ? FileId{info.st_dev, info.st_ino} : FileId{};
}

/** Takes the lock for as long as the descriptor lives. Its file holds our pid. */
Result<UniqueFd> lockFile(const std::string& path, const std::string& socket) {
  UniqueFd fd;
  bool locked = false;
  for (int attempt = 0; attempt < 10; ++attempt) {
    fd = UniqueFd(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!fd.valid()) {
      return systemError(
          path, "open", errno,
          unlessRunOut(errno, "this user must be able to write to the socket's folder; --socket names another"));
    }
    locked = flock(fd.get(), LOCK_EX | LOCK_NB) == 0;
    const bool same = idOf(fd.get()) == idAt(path);
    if (same || !locked) break;
    locked = false;  // its former owner removed the file after we had opened it: lock the new one
  }
  if (!locked) {
    char pid[16] = {};
    (void)!pread(fd.get(), pid, sizeof pid - 1, 0);
    pid[std::strspn(pid, "0123456789")] = 0;
    return Error{ErrorCode::kAlreadyExists, socket,
                 fmt::format("another hapticd{} serves this socket", *pid == 0 ? "" : fmt::format(" (pid {})", pid)),
                 "stop it, or give this one --socket in a folder of its own"};
  }
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(fd.get(), 0) != 0 || pwrite(fd.get(), pid.data(), pid.size(), 0) < 0)
    return systemError(path, "write", errno, "make room where the socket is to lie; --socket names another place");
  return fd;
}

Result<void> fits(const std::string& path) {
  constexpr std::size_t kMost = sizeof(sockaddr_un::sun_path) - 1;
  if (!path.empty() && path.size() <= kMost) return {};
  return Error{ErrorCode::kInvalidArgument, path, fmt::format("a socket's path has 1 to {} bytes", kMost),
               "choose a shorter one"};
}

Error noGroup(const std::string& group) {
  return {ErrorCode::kNotFound, "sockets.group", fmt::format("there is no group '{}'", group),
          "create it, or leave the key out"};
}

}  // namespace

Result<void> checkSocketPaths(const std::string& control, const std::string& admin) {
  // What is not given depends on who starts the daemon.
  const auto paths = control.empty() ? SocketPaths{{}, admin} : defaultSocketPaths(control, admin);
  if (!paths) return paths.error();
  for (const std::string& path : {paths->control, paths->admin}) {
    if (path.empty()) continue;
    if (auto r = fits(path); !r) return r;
  }
  return {};
}

Result<void> checkSocketGroup(const std::string& group) {
  if (group.empty() || getgrnam(group.c_str()) != nullptr) return {};
  return noGroup(group);
}

ListenSocket& ListenSocket::operator=(ListenSocket&& other) noexcept {
  if (this == &other) return *this;
  close();
  fd_ = std::move(other.fd_);
  lock_ = std::move(other.lock_);
  path_ = std::move(other.path_);
  file_ = std::exchange(other.file_, {});
  mode_ = std::exchange(other.mode_, 0);
  group_ = std::exchange(other.group_, kAnyGroup);
  return *this;
}

Result<ListenSocket> ListenSocket::bind(const std::string& path, unsigned mode, const std::string& group) {
  if (group.empty()) return bindFor(path, mode, kAnyGroup);
  const struct group* entry = getgrnam(group.c_str());
  if (entry == nullptr) return noGroup(group);
  return bindFor(path, mode, entry->gr_gid);
}

Result<ListenSocket> ListenSocket::bindFor(const std::string& path, unsigned mode, gid_t group) {
  if (auto r = fits(path); !r) return r.error();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  const std::string folder = folderOf(path);
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return systemError(folder, "mkdir", errno,
                       unlessRunOut(errno, "make the folder that holds it, or choose another path"));
  }

  ListenSocket out;
  out.path_ = path;
  out.mode_ = mode;
  out.group_ = group;
  auto lock = lockFile(path + ".lock", path);
  if (!lock) return lock.error();
  out.lock_ = std::move(*lock);
  struct stat info {};
  if (lstat(path.c_str(), &info) == 0) {
    if (!S_ISSOCK(info.st_mode)) {
      return Error{ErrorCode::kAlreadyExists, path, "it exists and is not a socket",
                   "remove it, or choose another path"};
    }
    (void)unlink(path.c_str());  // nobody holds the lock: its daemon is dead
  }
  out.fd_ = UniqueFd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!out.fd_.valid()) return systemError(path, "socket", errno);
  // Nobody connects before mode and group are right: the file gets the socket's mode (unix(7)), less what umask takes.
  if (fchmod(out.fd_.get(), 0600) != 0) return systemError(path, "fchmod", errno);
  if (::bind(out.fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return systemError(path, "bind", errno);
  out.file_ = idAt(path);
  if (group != kAnyGroup && chown(path.c_str(), static_cast<uid_t>(-1), group) != 0)
    return systemError(path, "chown", errno);
  if (chmod(path.c_str(), mode) != 0) return systemError(path, "chmod", errno);
  if (::listen(out.fd_.get(), kBacklog) != 0) return systemError(path, "listen", errno);
  return out;
}

ListenSocket ListenSocket::adopt(UniqueFd fd, std::string path) {
  ListenSocket out;
  out.fd_ = std::move(fd);
  out.path_ = std::move(path);
  return out;
}

bool ListenSocket::lost() const {
  if (mode_ == 0) return false;
  return file_ == FileId{} || lookAt(path_).value_or(file_) != file_;
}

Result<void> ListenSocket::renew() {
  const std::string path = path_;
  const gid_t group = group_;
  close();  // Its lock, too, for bind() takes that itself; a daemon that is quicker serves there then.
  auto made = bindFor(path, mode_, group);
  if (!made) return made.error();
  *this = std::move(*made);
  return {};
}

void ListenSocket::close() noexcept {
  // Where the folder was made anew, another daemon may serve there.
  const std::string lock = path_ + ".lock";
  if (file_ != FileId{} && idAt(path_) == file_) (void)unlink(path_.c_str());
  if (lock_.valid() && idAt(lock) == idOf(lock_.get())) (void)unlink(lock.c_str());
  file_ = {};
  fd_.reset();
  lock_.reset();
}

Result<SocketPaths> defaultSocketPaths(const std::string& control, const std::string& admin) {
  SocketPaths paths{control, admin};
  if (paths.control.empty()) {
    const std::string service = serviceFolder("RUNTIME_DIRECTORY");
    const std::string user = environment("XDG_RUNTIME_DIR");
    if (!service.empty()) {
      paths.control = service + "/control.sock";
    } else if (!user.empty()) {
      paths.control = user + "/hapticd/control.sock";
    } else if (geteuid() == 0) {
      paths.control = "/run/hapticd/control.sock";
    } else {
      return Error{ErrorCode::kNotFound, "XDG_RUNTIME_DIR",
                   "it is not set, so there is no place for the control socket", "set it, or give --socket PATH"};
    }
  }
  if (paths.admin.empty()) paths.admin = folderOf(paths.control) + "/admin.sock";
  if (paths.admin == paths.control) {
    return Error{ErrorCode::kInvalidArgument, paths.admin, "control and administration need a socket each",
                 "give --admin-socket PATH"};
  }
  return paths;
}

Result<ActivatedSockets> activatedSockets() {
  ActivatedSockets out;
  char** names = nullptr;
  const int count = sd_listen_fds_with_names(1, &names);
  if (count < 0) return systemError("systemd", "sd_listen_fds_with_names", -count);
  Result<void> result;
  for (int i = 0; i < count; ++i) {
    UniqueFd fd(SD_LISTEN_FDS_START + i);
    const std::string name = names != nullptr && names[i] != nullptr ? names[i] : "";
    sockaddr_un address{};
    socklen_t length = sizeof address - 1;  // keeps the path terminated
    (void)getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &length);
    (void)fcntl(fd.get(), F_SETFL, fcntl(fd.get(), F_GETFL) | O_NONBLOCK);
    const bool admin = name == "admin" || name.find("admin") != std::string::npos;
    ListenSocket& slot = admin ? out.admin : out.control;
    if (sd_is_socket_unix(fd.get(), SOCK_STREAM, 1, nullptr, 0) <= 0 || slot.valid()) {
      result = Error{ErrorCode::kInvalidArgument, fmt::format("systemd socket '{}'", name),
                     slot.valid() ? "there are two of its kind" : "it is not a listening Unix stream socket",
                     "use one ListenStream= with FileDescriptorName=control and one with FileDescriptorName=admin"};
    } else {
      slot = ListenSocket::adopt(std::move(fd), address.sun_path);
    }
    if (names != nullptr) std::free(names[i]);
  }
  std::free(names);
  if (!result) return result.error();
  return out;
}

}  // namespace hapticd
