/** @file
 * A simulated device of the running daemon, opened for a run.
 */
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <hapticclient/hapticclient.hpp>
#include <string>
#include <thread>

#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

/** The value, or a Failure with the daemon's words. */
template <class T>
T must(haptic::Result<T> result) {
  if (!result) throw Failure(result.error().message());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

inline void pauseBriefly() { std::this_thread::sleep_for(std::chrono::microseconds(100)); }

inline constexpr std::chrono::seconds kPatience{2};  ///< With a daemon that does not answer.

/** What the session's servo has published last. Throws Failure when it publishes nothing. */
[[nodiscard]] inline haptic_sample latestSample(const haptic::Session& session, const char* who) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    if (const haptic::Result<haptic_sample> s = session.latest()) return *s;
    if (std::chrono::steady_clock::now() > end) throw Failure(who, "its state cannot be read", "hapticctl status");
    pauseBriefly();
  }
}

/**
 * A device that is closed at the end, however it comes. One that is shared may stay for the others, with the last of
 * whom it closes by itself.
 */
class OpenedDevice {
 public:
  OpenedDevice(haptic::Client& client, const char* uri, bool shared = false)
      : client_(client), uri_(must(client.openDevice(uri))->uri), shared_(shared) {}
  ~OpenedDevice() {
    const haptic::Result<void> closed = client_.closeDevice(uri_);
    if (!closed && closed.code() != HAPTIC_DISCONNECTED && !(shared_ && closed.code() == HAPTIC_PERMISSION_DENIED))
      hapticd::tellError(fmt::format("haptic-bench: {} stays open: {}\n", uri_, closed.error().message()));
  }
  OpenedDevice(const OpenedDevice&) = delete;
  OpenedDevice& operator=(const OpenedDevice&) = delete;
  [[nodiscard]] const std::string& uri() const { return uri_; }

 private:
  haptic::Client& client_;
  std::string uri_;
  bool shared_;
};

}  // namespace haptic_bench
