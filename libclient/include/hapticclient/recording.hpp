/** @file
 * A recording of a device: a stream of bytes to be kept as it is.
 */
#pragma once

#include <hapticclient/record.h>

#include <hapticclient/result.hpp>
#include <memory>

namespace haptic {

/** Under way from Client::record() until stop(), or until this goes. */
class Recording {
 public:
  explicit Recording(haptic_recording* handle) noexcept : handle_(handle) {}

  /** The stream; the recording's own. Read it on a thread of its own until its end. */
  [[nodiscard]] int fd() const noexcept { return haptic_recording_fd(get()); }
  /** Ends it and waits until all is in the stream, or says how it has ended by itself. */
  Result<Reply<haptic_recording_end>> stop() {
    return detail::ask<haptic_recording_end>([&](auto** out, auto* e) { return haptic_recording_stop(get(), out, e); });
  }

  /** The handle of the C interface; still owned here. */
  [[nodiscard]] haptic_recording* get() const noexcept { return handle_.get(); }

 private:
  struct Close {
    void operator()(haptic_recording* handle) const noexcept { haptic_recording_close(handle); }
  };
  std::unique_ptr<haptic_recording, Close> handle_;
};

}  // namespace haptic
