#include "daemon/ipc/builder_protocol.h"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace hapticd {
namespace {

constexpr std::size_t kMostBytes = sizeof(BuilderFrameHead) + 3 * kBuilderMostText;
constexpr std::size_t kMostFds = 4;  ///< Room to receive what must not come, so that it can be closed.

/** Takes the descriptors of a message. False if there was more than one. */
bool takeFds(msghdr& message, UniqueFd& fd) {
  std::size_t count = 0;
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t here = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < here; ++i, ++count) {
      int raw = -1;
      std::memcpy(&raw, CMSG_DATA(c) + i * sizeof(int), sizeof raw);
      UniqueFd one(raw);
      if (count == 0) fd = std::move(one);
    }
  }
  return count <= 1;
}

}  // namespace

FrameIo sendFrame(int socket, const BuilderFrame& frame, int fd, bool nonblocking) {
  char bytes[kMostBytes];
  BuilderFrameHead head = frame.head;
  std::size_t size = sizeof head;
  for (std::size_t i = 0; i < 3; ++i) {
    head.text_bytes[i] = static_cast<std::uint32_t>(std::min<std::size_t>(frame.text[i].size(), kBuilderMostText));
    std::memcpy(bytes + size, frame.text[i].data(), head.text_bytes[i]);
    size += head.text_bytes[i];
  }
  std::memcpy(bytes, &head, sizeof head);
  iovec part{bytes, size};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  if (fd >= 0) {
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    cmsghdr* const c = CMSG_FIRSTHDR(&message);
    c->cmsg_level = SOL_SOCKET;
    c->cmsg_type = SCM_RIGHTS;
    c->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(c), &fd, sizeof fd);
  }
  for (;;) {
    if (::sendmsg(socket, &message, MSG_NOSIGNAL | (nonblocking ? MSG_DONTWAIT : 0)) >= 0) return FrameIo::kOk;
    if (errno == EINTR) continue;
    return errno == EAGAIN || errno == ENOBUFS ? FrameIo::kLater : FrameIo::kClosed;
  }
}

FrameIo receiveFrame(int socket, BuilderFrame& frame, bool nonblocking) {
  char bytes[kMostBytes];
  iovec part{bytes, sizeof bytes};
  alignas(cmsghdr) char control[CMSG_SPACE(kMostFds * sizeof(int))];
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  ssize_t size = -1;
  do {
    size = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC | (nonblocking ? MSG_DONTWAIT : 0));
  } while (size < 0 && errno == EINTR);
  if (size < 0) return errno == EAGAIN ? FrameIo::kLater : FrameIo::kClosed;
  if (size == 0) return FrameIo::kClosed;
  frame = {};
  const bool one = takeFds(message, frame.fd);
  const auto bad = [&] {
    frame.fd.reset();
    return FrameIo::kBad;
  };
  if (one && !frame.fd.valid() && (message.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) == MSG_CTRUNC)
    return FrameIo::kNoDescriptor;
  if (!one || (message.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0) return bad();
  if (static_cast<std::size_t>(size) < sizeof frame.head) return bad();
  std::memcpy(&frame.head, bytes, sizeof frame.head);
  if (frame.head.protocol != BuilderFrameHead{}.protocol) return bad();
  std::size_t at = sizeof frame.head;
  for (std::size_t i = 0; i < 3; ++i) {
    if (frame.head.text_bytes[i] > static_cast<std::size_t>(size) - at) return bad();
    frame.text[i].assign(bytes + at, frame.head.text_bytes[i]);
    at += frame.head.text_bytes[i];
  }
  return at == static_cast<std::size_t>(size) ? FrameIo::kOk : bad();
}

}  // namespace hapticd
