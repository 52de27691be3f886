/** @file
 * Where clients find the daemon: paths, takeover from systemd, refusal of a second daemon.
 */
#pragma once

#include <sys/types.h>

#include <string>

#include "daemon/ipc/unique_fd.h"

namespace hapticd {

/** Which file it is, wherever it lies; none by default. */
struct FileId {
  dev_t device = 0;
  ino_t inode = 0;
  bool operator==(const FileId&) const = default;
};

/** A listening Unix socket; its file and lock go with it if the daemon made them and nobody has put others there. */
class ListenSocket {
 public:
  ListenSocket() noexcept = default;
  ListenSocket(ListenSocket&& other) noexcept { *this = std::move(other); }
  ListenSocket& operator=(ListenSocket&& other) noexcept;
  ListenSocket(const ListenSocket&) = delete;
  ListenSocket& operator=(const ListenSocket&) = delete;
  ~ListenSocket() { close(); }

  /**
   * Locks `path`.lock, removes a socket that a dead daemon left, binds and listens. A missing folder is made, mode
   * 0700. kAlreadyExists names the pid of the daemon that serves the path. `group`: empty, or the group that may
   * connect.
   */
  [[nodiscard]] static Result<ListenSocket> bind(const std::string& path, unsigned mode, const std::string& group);
  /** A socket that systemd listens on. */
  [[nodiscard]] static ListenSocket adopt(UniqueFd fd, std::string path);

  /** A descriptor for the event loop. */
  [[nodiscard]] Result<UniqueFd> share() const { return duplicate(fd_.get()); }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] bool valid() const { return fd_.valid(); }
  /**
   * Whether it is one that bind() made and that nobody can find any more: removed, or another stands there. Not where
   * that cannot be seen, as in a folder whose rights were taken away: it is found again when they come back.
   */
  [[nodiscard]] bool lost() const;
  /** bind() once more, in the place of one that is lost. After an error it is still lost. Asks nobody for the group. */
  [[nodiscard]] Result<void> renew();
  void close() noexcept;

 private:
  static constexpr gid_t kAnyGroup = static_cast<gid_t>(-1);  ///< As chown() has it.
  static Result<ListenSocket> bindFor(const std::string& path, unsigned mode, gid_t group);

  UniqueFd fd_, lock_;
  std::string path_;
  FileId file_;        ///< What we made; nothing if we did not.
  unsigned mode_ = 0;  ///< As given to bind(); 0: this is not its.
  gid_t group_ = kAnyGroup;
};

/** The two sockets of this daemon. */
struct SocketPaths {
  std::string control, admin;
};
/** Empty ones by default: in $RUNTIME_DIRECTORY (a service), $XDG_RUNTIME_DIR/hapticd, or as root /run/hapticd. */
[[nodiscard]] Result<SocketPaths> defaultSocketPaths(const std::string& control, const std::string& admin);

/** Whether sockets can lie there, as far as paths are given. kInvalidArgument. */
[[nodiscard]] Result<void> checkSocketPaths(const std::string& control, const std::string& admin);

/** Whether there is a group of that name, or none is wanted. kNotFound. */
[[nodiscard]] Result<void> checkSocketGroup(const std::string& group);

/** Sockets that systemd passed, by FileDescriptorName= "control" and "admin"; others are refused by name. */
struct ActivatedSockets {
  ListenSocket control, admin;
};
[[nodiscard]] Result<ActivatedSockets> activatedSockets();

}  // namespace hapticd
