#include "libclient/src/connection/socket_search.h"

#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <ctime>

namespace hapticd::client {
namespace {

std::string environment(const char* name) {
  const char* value = secure_getenv(name);
  return value == nullptr ? std::string() : value;
}

std::string besides(const std::string& path, const char* name) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? name : path.substr(0, slash + 1) + name;
}

/** What is wrong with a path that refuses a connection. */
Failure refusedAt(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0 || S_ISSOCK(info.st_mode))
    return {HAPTIC_DISCONNECTED, path, "nobody listens", {}};
  if (S_ISDIR(info.st_mode))
    return badArgument(path, "is a folder", "name the socket in it: " + path + "/control.sock");
  return {HAPTIC_DISCONNECTED, path, "is not a socket", {}};
}

/** Who may connect, as far as the socket says so. Blocks as long as a look-up of a group does. */
std::string remedyOf(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return "its folder is closed to this user: ask whoever runs that daemon";
  if ((info.st_mode & S_IWGRP) == 0)
    return "this socket is for its owner alone: use the control socket, or become that user";
  if (info.st_gid == 0)
    return "its daemon shares it with root alone: name a group in sockets.group of its configuration";
  group entry{};
  group* found = nullptr;
  char buffer[4096];
  if (getgrgid_r(info.st_gid, &entry, buffer, sizeof buffer, &found) != 0 || found == nullptr) return "ask its owner";
  return std::string("join the group ") + found->gr_name + ", then log in again";
}

}  // namespace

SocketSearch searchHere(std::string given, bool administration) {
  return {std::move(given), environment("HAPTICD_SOCKET"), environment("XDG_RUNTIME_DIR"), administration};
}

std::vector<std::string> candidates(const SocketSearch& search) {
  if (!search.given.empty()) return {search.given};
  const char* name = search.administration ? "admin.sock" : "control.sock";
  if (!search.environment.empty()) {
    return {search.administration ? besides(search.environment, name) : search.environment};
  }
  std::vector<std::string> paths;
  if (!search.runtime_dir.empty()) paths.push_back(search.runtime_dir + "/hapticd/" + name);
  paths.push_back(std::string("/run/hapticd/") + name);
  return paths;
}

Failure connectTo(const std::string& path, std::int64_t timeout_ns, OwnDescriptor& connected) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    return badArgument(path, "is longer than a socket path can be",
                       "use a path of at most " + std::to_string(sizeof address.sun_path - 1) + " bytes");
  }
  path.copy(address.sun_path, path.size());
  OwnDescriptor made([] { return socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); });
  if (made.get() < 0)
    return {HAPTIC_SYSTEM, path, std::string("no socket can be made: ") + strerror(errno), kFewerDescriptors};
  const std::int64_t deadline = haptic_now_ns() + timeout_ns;
  for (;;) {
    if (connect(made.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
      connected = std::move(made);
      return {};
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN || haptic_now_ns() >= deadline) break;
    const timespec pause{0, 2'000'000};  // the daemon's backlog is full
    nanosleep(&pause, nullptr);
  }
  switch (const int error = errno) {
    case ENOENT:
      return {HAPTIC_DISCONNECTED, path, "no such socket", {}};
    case ECONNREFUSED:
      return refusedAt(path);
    case EACCES:
    case EPERM:
      return {HAPTIC_PERMISSION_DENIED, path, "you may not connect", remedyOf(path)};
    case EAGAIN:
      return {HAPTIC_TIMEOUT, path, "the daemon does not take connections", {}};
    default:
      return {HAPTIC_SYSTEM, path, strerror(error), {}};
  }
}

Failure nobodyAnswers(const std::vector<std::string>& paths, const std::vector<Failure>& why) {
  if (why.size() == 1 && why[0].code != HAPTIC_DISCONNECTED) return why[0];
  Failure all{
      HAPTIC_DISCONNECTED, {}, {}, "start the daemon: systemctl start hapticd, or /usr/sbin/hapticd --allow-no-rt"};
  const auto as_first = [&](const Failure& f) { return f.code == why[0].code; };
  if (!why.empty() && std::all_of(why.begin(), why.end(), as_first)) all.code = why[0].code;
  const bool alike = std::all_of(why.begin(), why.end(), [&](const Failure& f) { return f.what == why[0].what; });
  if (alike && !why.empty()) all.what = why[0].what;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    all.where += (i == 0 ? "" : ", ") + paths[i];
    if (!alike) all.what += (i == 0 ? "" : "; ") + paths[i] + ": " + why[i].what;
    const bool denied = why[i].code == HAPTIC_PERMISSION_DENIED, late = why[i].code == HAPTIC_TIMEOUT;
    if (denied || (late && all.code == HAPTIC_DISCONNECTED)) all.code = why[i].code;
    // There is a daemon. A path that cannot be one is not this program's choice: it gave none.
    if (!why[i].remedy.empty() && why[i].code != HAPTIC_INVALID_ARGUMENT) all.remedy = why[i].remedy;
  }
  return all;
}

}  // namespace hapticd::client
