/** @file
 * A played HID device before the kernel itself: by /dev/uhid, which makes HID devices of programs. Programs then find
 * it through udev and hidraw as any other. Needs root and the module uhid.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "tools/haptic-emu/hid_model.h"

struct uhid_event;

namespace haptic_emu {

/** What the kernel is told that it is. */
struct HidIdentity {
  std::string name, serial;
  std::uint16_t vendor = 0, product = 0;
};

/** The kernel's messages about one device, to and fro (linux/uhid.h). One thread. Does not own `fd`. */
class UhidLink {
 public:
  UhidLink(int fd, HidModel& model, HidIdentity identity) : fd_(fd), model_(model), identity_(std::move(identity)) {}

  /**
   * Answers what the kernel asked, hands on what the model says, plugs in and out as the model does. Never waits.
   * False: the kernel does not take it; errno says why.
   */
  [[nodiscard]] bool pump(std::int64_t now_ns);
  /** Takes the device out of the kernel. */
  void unplug();
  [[nodiscard]] bool plugged() const { return plugged_; }
  /** Whether a program has the node open. Only then the kernel wants to hear anything. */
  [[nodiscard]] bool opened() const { return opened_; }

 private:
  [[nodiscard]] bool plugIn();
  /** One message of the kernel's, answered if it wants an answer. */
  [[nodiscard]] bool take(const uhid_event& event);

  int fd_;
  HidModel& model_;
  HidIdentity identity_;
  bool plugged_ = false, opened_ = false;
};

/** Plays `model` in real time until `stop`. `each` is called every 250 us of it. */
[[nodiscard]] hapticd::Result<void> playToUhid(HidModel& model, const HidIdentity& identity,
                                               const std::atomic<bool>& stop,
                                               const std::function<void(std::int64_t now_ns)>& each);

}  // namespace haptic_emu
