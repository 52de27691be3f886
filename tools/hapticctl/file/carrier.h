/** @file
 * The stream of a recording on its way into a file.
 */
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace hapticctl {

/**
 * Reads the stream on one thread and writes it on another, so that the stream is read on while a slow disk takes what
 * came before: the daemon ends a recording whose stream stands still. On the disk every 0.75 s, as long as that keeps
 * up.
 */
class Carrier {
 public:
  static constexpr std::size_t kRoom = std::size_t{64} << 20;  ///< For what is read and not yet written.

  /** Both are called on one thread, and give 0 or errno; after an error neither is called again. */
  struct Target {
    std::function<int(const char*, std::size_t)> write;
    std::function<int()> sync;
  };

  /** The stream is a socket. */
  Carrier(int stream, Target target);
  ~Carrier() { join(); }
  Carrier(const Carrier&) = delete;
  Carrier& operator=(const Carrier&) = delete;

  /** Waits for the stream's end and until all is written. */
  void join();
  /** Waits at most so long for the stream's end and takes no more then; until what came is written. */
  void end(std::chrono::milliseconds patience);
  [[nodiscard]] bool over() const { return over_.load(); }
  [[nodiscard]] int problem() const { return problem_.load(); }  ///< errno of the target, or 0.

 private:
  void take();
  void keep();
  void giveUp(int problem);

  const int stream_;
  const Target target_;
  const std::unique_ptr<char[]> room_;  ///< A ring; the kernel gives its pages as they are needed.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t first_ = 0, filled_ = 0;  ///< Under the mutex.
  bool ended_ = false;                  ///< The stream. Under the mutex.
  std::atomic<bool> over_{false};
  std::atomic<int> problem_{0};
  std::thread keeper_, taker_;
};

}  // namespace hapticctl
