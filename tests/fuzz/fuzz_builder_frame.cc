// Datagrams between daemon and builder: whatever bytes and descriptors come, they are refused, or a frame that is the
// same when sent on. No descriptor is left open.
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "daemon/ipc/builder_protocol.h"

namespace {

void require(bool held) {
  if (!held) __builtin_trap();
}

/** Sends bytes as they are, with so many descriptors. */
void sendRaw(int socket, const std::uint8_t* data, std::size_t size, std::size_t descriptors) {
  iovec part{const_cast<std::uint8_t*>(data), size};
  alignas(cmsghdr) char control[CMSG_SPACE(8 * sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (descriptors > 0) {
    message.msg_control = control;
    message.msg_controllen = CMSG_SPACE(descriptors * sizeof(int));
    cmsghdr* const c = CMSG_FIRSTHDR(&message);
    c->cmsg_level = SOL_SOCKET;
    c->cmsg_type = SCM_RIGHTS;
    c->cmsg_len = CMSG_LEN(descriptors * sizeof(int));
    for (std::size_t i = 0; i < descriptors; ++i) std::memcpy(CMSG_DATA(c) + i * sizeof(int), &socket, sizeof socket);
  }
  require(sendmsg(socket, &message, MSG_NOSIGNAL) == static_cast<ssize_t>(size));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  if (size < 2) return 0;
  const std::size_t descriptors = data[0] % 7;
  const bool sound = (data[0] & 0x80) != 0;  // as a frame that says what it is; else any bytes
  ++data, --size;
  int pair[2];
  require(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) == 0);
  const int next_free = fcntl(pair[0], F_DUPFD_CLOEXEC, 0);
  close(next_free);

  BuilderFrame sent;
  if (sound) {
    std::memcpy(static_cast<void*>(&sent.head), data, std::min(size, sizeof sent.head));
    sent.head.protocol = BuilderFrameHead{}.protocol;
    for (std::string& text : sent.text) text.assign(reinterpret_cast<const char*>(data), size);
    require(sendFrame(pair[0], sent, descriptors > 0 ? pair[0] : -1, true) == FrameIo::kOk);
  } else {
    sendRaw(pair[0], data, size, descriptors);
  }
  {
    BuilderFrame frame, again;
    const FrameIo got = receiveFrame(pair[1], frame, true);
    require(got == FrameIo::kOk || (!sound && got == FrameIo::kBad));
    require(got == FrameIo::kOk || !frame.fd.valid());
    require(sound || descriptors <= 1 || got == FrameIo::kBad);
    require(!sound || frame.fd.valid() == (descriptors > 0));
    require(receiveFrame(pair[1], again, true) == FrameIo::kLater);
    const bool fits = std::all_of(frame.text.begin(), frame.text.end(),
                                  [](const std::string& text) { return text.size() <= kBuilderMostText; });
    if (got == FrameIo::kOk && fits) {
      require(sendFrame(pair[0], frame, frame.fd.get(), true) == FrameIo::kOk);
      require(receiveFrame(pair[1], again, true) == FrameIo::kOk);
      require(std::memcmp(&again.head, &frame.head, sizeof frame.head) == 0 && again.text == frame.text);
      require(again.fd.valid() == frame.fd.valid());
    }
  }
  const int now_free = fcntl(pair[0], F_DUPFD_CLOEXEC, 0);
  close(now_free);
  require(now_free == next_free);
  close(pair[0]);
  close(pair[1]);
  return 0;
}
