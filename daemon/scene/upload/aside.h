/** @file
 * Work too long for the control thread, which must always be there to stop a device.
 */
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

#include "daemon/leash/turns.h"
#include "rt/base/error.h"

namespace hapticd {

/** From so many bytes on giving memory back takes the kernel long: 2 ms for 32 MB, some of it waiting for others. */
inline constexpr std::uint64_t kLargeBytes = 4 << 20;

/** One job after the other on a thread of its own, begun with the first; each client has its turn. Control thread only.
 */
class Aside {
 public:
  Aside() = default;
  /** Waits for the job under way; the others, and whoever waits for them, hear nothing more. */
  ~Aside();
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  /**
   * `work`, which gives a Result, runs on the thread, where what it holds goes, too: giving large memory back takes its
   * time. `done` gets the result in a later poll(). Returns the job's number, from 1.
   */
  template <class Work, class Done>
  std::uint64_t start(Work work, Done done, std::uint64_t client = 0) {
    struct State {
      std::optional<Work> work;
      Done done;
      std::optional<std::invoke_result_t<Work&>> result;
    };
    const auto state = std::make_shared<State>(State{std::move(work), std::move(done), {}});
    const auto number = ++last_;
    push({number,
          [state](bool dropped) {
            try {
              if (dropped) {
                state->result.emplace(Error{ErrorCode::kCancelled, {}, {}, {}});
              } else {
                state->result.emplace((*state->work)());
              }
            } catch (const std::bad_alloc&) {  // Nobody is above us.
              state->result.emplace(noMemory());
            } catch (const std::exception& e) {
              state->result.emplace(Error{ErrorCode::kInternal, {}, e.what(), {}});
            }
            state->work.reset();
          },
          [state] { state->done(std::move(*state->result)); }},
         client);
    return number;
  }
  /** Nobody waits for that job: if it is not begun it is not worked on, and `done` gets kCancelled before the others.
   */
  void cancel(std::uint64_t number);
  /**
   * `held` goes on the thread, and `done` is called in a later poll(). False where there is no memory for the job: it
   * went here, and `done` is not called.
   */
  template <class Held, class Done>
  bool letGo(Held held, Done done) noexcept {
    try {
      (void)start([held = std::move(held)] { return Result<void>(); },
                  [done = std::move(done)](const Result<void>&) mutable { done(); });
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }
  /** Tells what is done. */
  void poll();
  /** With no text that would need some. */
  [[nodiscard]] static Error noMemory() { return {ErrorCode::kSystem, "memory", {}, {}}; }
  /** Jobs begun or waiting, or not told yet. */
  [[nodiscard]] std::size_t size() const;

 private:
  struct Job {
    std::uint64_t number;
    std::function<void(bool dropped)> work;
    std::function<void()> tell;
  };
  void push(Job job, std::uint64_t client);
  void run();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Lists: the thread hands one on without memory, for nobody would take its exception.
  Turns<Job> waiting_;
  std::list<Job> dropped_;  ///< Of those that waited.
  std::list<Job> begun_;    ///< One at most.
  std::list<Job> finished_;
  bool stopping_ = false;
  std::uint64_t last_ = 0;
  std::thread thread_;
};

}  // namespace hapticd
