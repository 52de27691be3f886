/** @file
 * Between the daemon and hapticd-builder: one datagram per message over a SOCK_SEQPACKET pair, which keeps boundaries.
 *
 * Daemon to builder: kBuild (with the upload's descriptor), kCancel. Builder to daemon, for one job: any number of
 * kProgress and kNote, at most one kVolume (with its descriptor), then kDone (with the snapshot's) or kFailed. One job
 * at a time.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "daemon/ipc/build_stats.h"
#include "daemon/ipc/unique_fd.h"

namespace hapticd {

inline constexpr int kBuilderSocket = 3;                ///< Where the builder finds its end.
inline constexpr std::uint32_t kBuilderMostText = 512;  ///< Bytes of each text; longer ones are cut.

enum class BuilderFrameKind : std::uint32_t { kBuild = 1, kCancel, kProgress, kNote, kDone, kFailed, kVolume };

/** The head of a datagram; up to three texts follow (stage; note; where, what, remedy). */
struct BuilderFrameHead {
  std::uint32_t protocol = 1;
  BuilderFrameKind kind{};
  std::uint64_t job = 0;
  float fraction = 0;
  std::uint32_t error = 0;  ///< ErrorCode of kFailed.
  std::array<std::uint32_t, 3> text_bytes{};
  std::uint32_t reserved = 0;
  BuildStats stats;
};
static_assert(std::is_trivially_copyable_v<BuilderFrameHead>);

struct BuilderFrame {
  BuilderFrameHead head;
  std::array<std::string, 3> text;
  UniqueFd fd;
};

enum class FrameIo {
  kOk,
  kLater,         ///< Nothing there, or no room.
  kClosed,        ///< The other end is gone.
  kBad,           ///< Truncated, of another protocol, or with more descriptors than one.
  kNoDescriptor,  ///< One came, but this process can have no more of them: the datagram is lost.
};

/** Never blocks if `nonblocking`; `fd` < 0 sends none. */
[[nodiscard]] FrameIo sendFrame(int socket, const BuilderFrame& frame, int fd, bool nonblocking);
/** Received descriptors are closed on exec; those of a bad datagram are closed at once. */
[[nodiscard]] FrameIo receiveFrame(int socket, BuilderFrame& frame, bool nonblocking);

}  // namespace hapticd
