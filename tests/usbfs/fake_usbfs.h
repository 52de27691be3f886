/** @file
 * A kernel's usbfs for one played device, below the real libusb: this program's own open, ioctl and lseek answer for
 * the device's node and hand on all else. Plain builds only: sanitizers bring their own.
 */
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/usb/usb_list.h"
#include "tools/haptic-emu/usb_model.h"

struct usbdevfs_urb;

namespace hapticd::test {

/** While it lives, device().node() is there and `model` is behind it, in real time. One at a time. */
class FakeUsbfs {
 public:
  explicit FakeUsbfs(haptic_emu::UsbModel& model);
  ~FakeUsbfs();

  /** As findUsb() would find it. */
  [[nodiscard]] static UsbFound device();

  std::atomic<bool> busy{false};       ///< Another program has claimed the interface.
  std::atomic<bool> forbidden{false};  ///< No right to the node.
  /** What holds the interface while nobody has claimed it; "" for nothing. */
  std::string kernel_driver;
  std::atomic<int> claims{0}, releases{0}, detached{0}, given_back{0}, sent_at_once{0};
  std::atomic<std::size_t> left{0};          ///< Requests that still waited when their interface was given back.
  std::atomic<std::size_t> most_waiting{0};  ///< IN requests that waited together.
  std::atomic<int> outs{0}, unawaited{0};    ///< OUTs, and those that came while no IN was waiting.

  /** For tests that touch the model while it is played. */
  std::unique_lock<std::mutex> hold() { return std::unique_lock(mutex_); }

  // What the program's own system calls hand over.
  int openNode();
  void closeNode(int fd);
  [[nodiscard]] bool owns(int fd);
  int ioctlNode(int fd, unsigned long request, void* argument);
  static FakeUsbfs* alive() { return alive_.load(); }

 private:
  struct Node {
    int ours, peer;
    std::deque<usbdevfs_urb*> done;
    std::deque<usbdevfs_urb*> waiting;
    bool claimed = false, writable = true;
  };

  void play();
  int submit(Node& node, usbdevfs_urb* urb);
  int reap(Node& node, void** urb);
  int discard(Node& node, usbdevfs_urb* urb);
  int claim(Node& node, bool detach);
  void end(Node& node, usbdevfs_urb* urb, int status);
  void match(Node& node);
  static void show(Node& node);

  static std::atomic<FakeUsbfs*> alive_;
  haptic_emu::UsbModel& model_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace hapticd::test
