#include "tests/usbfs/fake_usbfs.h"

#include <fcntl.h>
#include <linux/ioctl.h>
#include <linux/usbdevice_fs.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstring>

#include "rt/base/clock.h"
#include "tools/haptic-emu/usb_descriptors.h"

namespace hapticd::test {
namespace {

int refuse(int error) {
  errno = error;
  return -1;
}

}  // namespace

std::atomic<FakeUsbfs*> FakeUsbfs::alive_{nullptr};

FakeUsbfs::FakeUsbfs(haptic_emu::UsbModel& model) : model_(model) {
  model_.startAt(MonotonicClock().now());
  alive_.store(this);
  thread_ = std::thread([this] { play(); });
}

FakeUsbfs::~FakeUsbfs() {
  stop_.store(true);
  thread_.join();
  alive_.store(nullptr);
  for (const auto& node : nodes_) syscall(SYS_close, node->peer);
}

UsbFound FakeUsbfs::device() {
  UsbFound device;
  device.vendor = 0x0403;
  device.product = 0xcb48;
  device.bus = device.address = 998;
  device.path = "998-1";
  return device;
}

void FakeUsbfs::play() {
  MonotonicClock clock;
  while (!stop_.load()) {
    clock.sleepUntil(clock.now() + 250'000);
    const std::scoped_lock lock(mutex_);
    model_.advance(clock.now());
    for (const auto& node : nodes_) match(*node);
  }
}

/** A node is a socket: the kernel's "a transfer has ended" is "you may write", so its buffer is kept full until then.
 */
int FakeUsbfs::openNode() {
  if (forbidden) return refuse(EACCES);
  const std::scoped_lock lock(mutex_);
  model_.advance(MonotonicClock().now());
  if (!model_.plugged()) return refuse(ENOENT);
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return -1;
  auto node = std::make_unique<Node>(Node{ends[0], ends[1], {}, {}});
  // The kernel lets a node be read: its descriptors.
  for (const std::uint16_t kind : {1, 2}) {
    const auto bytes =
        *haptic_emu::answerStandard(model_.identity(), {0x80, 6, static_cast<std::uint16_t>(kind << 8), 0, 255});
    if (write(ends[1], bytes.data(), bytes.size()) < 0) return -1;
  }
  show(*node);
  nodes_.push_back(std::move(node));
  return ends[0];
}

void FakeUsbfs::closeNode(int fd) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(nodes_, [&](const auto& node) { return node->ours == fd && syscall(SYS_close, node->peer) == 0; });
}

bool FakeUsbfs::owns(int fd) {
  const std::scoped_lock lock(mutex_);
  return std::any_of(nodes_.begin(), nodes_.end(), [fd](const auto& node) { return node->ours == fd; });
}

void FakeUsbfs::show(Node& node) {
  std::array<char, 4096> bytes{};
  if (!node.done.empty()) {
    while (recv(node.peer, bytes.data(), bytes.size(), MSG_DONTWAIT) > 0) {
    }
    node.writable = true;
  } else if (node.writable) {
    while (send(node.ours, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) > 0) {
    }
    node.writable = false;
  }
}

void FakeUsbfs::end(Node& node, usbdevfs_urb* urb, int status) {
  urb->status = status;
  node.done.push_back(urb);
  show(node);
}

void FakeUsbfs::match(Node& node) {
  if (!model_.plugged()) {
    for (; !node.waiting.empty(); node.waiting.pop_front()) end(node, node.waiting.front(), -ESHUTDOWN);
    return;
  }
  while (!node.waiting.empty()) {
    usbdevfs_urb* const urb = node.waiting.front();
    const auto bytes = model_.in(static_cast<std::size_t>(urb->buffer_length));
    if (!bytes) return;
    std::memcpy(urb->buffer, bytes->data(), bytes->size());
    urb->actual_length = static_cast<int>(bytes->size());
    node.waiting.pop_front();
    end(node, urb, 0);
  }
}

int FakeUsbfs::submit(Node& node, usbdevfs_urb* urb) {
  if (!model_.plugged()) return refuse(ENODEV);
  auto* const bytes = static_cast<std::uint8_t*>(urb->buffer);
  const auto length = static_cast<std::size_t>(urb->buffer_length);
  urb->actual_length = 0;
  if (urb->type == USBDEVFS_URB_TYPE_CONTROL) {
    const auto pair = [&](std::size_t i) { return static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8); };
    end(node, urb, model_.control({bytes[0], bytes[1], pair(2), pair(4)}) ? 0 : -EPIPE);
    return 0;
  }
  if (!node.claimed) return refuse(EBUSY);
  if ((urb->endpoint & 0x80) != 0) {
    node.waiting.push_back(urb);
    most_waiting = std::max<std::size_t>(most_waiting, node.waiting.size());
    return 0;
  }
  ++outs;
  if (node.waiting.empty()) ++unawaited;
  model_.out({bytes, length});
  urb->actual_length = urb->buffer_length;
  end(node, urb, 0);
  return 0;
}

int FakeUsbfs::reap(Node& node, void** urb) {
  if (node.done.empty()) return refuse(model_.plugged() ? EAGAIN : ENODEV);
  *urb = node.done.front();
  node.done.pop_front();
  show(node);
  return 0;
}

int FakeUsbfs::discard(Node& node, usbdevfs_urb* urb) {
  const auto at = std::find(node.waiting.begin(), node.waiting.end(), urb);
  if (at == node.waiting.end()) return refuse(EINVAL);
  node.waiting.erase(at);
  end(node, urb, -ENOENT);
  return 0;
}

int FakeUsbfs::claim(Node& node, bool detach) {
  if (!model_.plugged()) return refuse(ENODEV);
  const bool taken =
      std::any_of(nodes_.begin(), nodes_.end(), [&](const auto& n) { return n.get() != &node && n->claimed; });
  if (busy || taken) return refuse(EBUSY);
  if (!kernel_driver.empty()) {
    if (!detach) return refuse(EBUSY);
    kernel_driver.clear();
    ++detached;
  }
  node.claimed = true;
  ++claims;
  return 0;
}

int FakeUsbfs::ioctlNode(int fd, unsigned long request, void* argument) {
  const std::scoped_lock lock(mutex_);
  model_.advance(MonotonicClock().now());
  Node& node = **std::find_if(nodes_.begin(), nodes_.end(), [fd](const auto& n) { return n->ours == fd; });
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      *static_cast<std::uint32_t*>(argument) = 0;
      return 0;
    case USBDEVFS_CONNECTINFO:
      *static_cast<usbdevfs_connectinfo*>(argument) = {998, 0};
      return 0;
    case USBDEVFS_CLAIMINTERFACE:
      return claim(node, false);
    case USBDEVFS_DISCONNECT_CLAIM:
      return claim(node, true);
    case USBDEVFS_RELEASEINTERFACE:
      node.claimed = false;
      left += node.waiting.size();
      ++releases;
      return 0;
    case USBDEVFS_GETDRIVER: {
      if (kernel_driver.empty() && !busy) return refuse(ENODATA);
      auto* const driver = static_cast<usbdevfs_getdriver*>(argument);
      std::strncpy(driver->driver, busy ? "usbfs" : kernel_driver.c_str(), USBDEVFS_MAXDRIVERNAME);
      return 0;
    }
    case USBDEVFS_IOCTL: {
      const auto code = static_cast<unsigned long>(static_cast<usbdevfs_ioctl*>(argument)->ioctl_code);
      if (code == (USBDEVFS_DISCONNECT & 0xffffffffu)) {
        if (kernel_driver.empty()) return refuse(ENODATA);
        kernel_driver.clear();
        ++detached;
      } else {
        ++given_back;
      }
      return code == (USBDEVFS_CONNECT & 0xffffffffu) ? 1 : 0;
    }
    case USBDEVFS_SUBMITURB:
      return submit(node, static_cast<usbdevfs_urb*>(argument));
    case USBDEVFS_REAPURBNDELAY:
      return reap(node, static_cast<void**>(argument));
    case USBDEVFS_DISCARDURB:
      return discard(node, static_cast<usbdevfs_urb*>(argument));
    case USBDEVFS_BULK: {
      auto* const bulk = static_cast<usbdevfs_bulktransfer*>(argument);
      if (!model_.plugged()) return refuse(ENODEV);
      if (!node.claimed) return refuse(EBUSY);
      model_.out({static_cast<std::uint8_t*>(bulk->data), bulk->len});
      ++sent_at_once;
      return static_cast<int>(bulk->len);
    }
    default:
      return refuse(ENOTTY);
  }
}

}  // namespace hapticd::test

using hapticd::test::FakeUsbfs;

// The program's own: libusb and the driver find these before the C library's.
extern "C" {

int ioctl(int fd, unsigned long request, ...) {
  va_list list;
  va_start(list, request);
  void* const argument = va_arg(list, void*);
  va_end(list);
  FakeUsbfs* const usbfs = FakeUsbfs::alive();
  if (usbfs != nullptr && usbfs->owns(fd)) return usbfs->ioctlNode(fd, request, argument);
  return static_cast<int>(syscall(SYS_ioctl, fd, request, argument));
}

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const int mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, int) : 0;
  va_end(list);
  FakeUsbfs* const usbfs = FakeUsbfs::alive();
  if (usbfs != nullptr && FakeUsbfs::device().node() == path) return usbfs->openNode();
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

int close(int fd) {
  FakeUsbfs* const usbfs = FakeUsbfs::alive();
  if (usbfs != nullptr && usbfs->owns(fd)) usbfs->closeNode(fd);
  return static_cast<int>(syscall(SYS_close, fd));
}

off64_t lseek64(int fd, off64_t offset, int whence) noexcept {
  FakeUsbfs* const usbfs = FakeUsbfs::alive();
  if (usbfs != nullptr && usbfs->owns(fd)) return 0;
  return syscall(SYS_lseek, fd, offset, whence);
}
off_t lseek(int fd, off_t offset, int whence) noexcept { return lseek64(fd, offset, whence); }

}  // extern "C"
