/** @file
 * Work too long for the control thread, which must always be there to stop a device.
 */
#pragma once

#include <condition_variable>
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

#include "rt/base/error.h"

namespace hapticd {

/** One job after the other on a thread of its own, begun with the first. Control thread only. */
class Aside {
 public:
  Aside() = default;
  /** Waits for the job under way; the others, and whoever waits for them, hear nothing more. */
  ~Aside();
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  /** `work`, which gives a Result, runs on the thread; `done` gets that in a later poll(). */
  template <class Work, class Done>
  void start(Work work, Done done) {
    struct Job {
      Work work;
      Done done;
      std::optional<std::invoke_result_t<Work&>> result;
    };
    const auto job = std::make_shared<Job>(Job{std::move(work), std::move(done), {}});
    push({[job] {
            try {
              job->result.emplace(job->work());
            } catch (const std::bad_alloc&) {  // Nobody is above us.
              job->result.emplace(noMemory());
            } catch (const std::exception& e) {
              job->result.emplace(Error{ErrorCode::kInternal, {}, e.what(), {}});
            }
          },
          [job] { job->done(std::move(*job->result)); }});
  }
  /** Tells what is done. */
  void poll();
  /** Jobs begun or waiting, or not told yet. */
  [[nodiscard]] std::size_t size() const;

 private:
  struct Job {
    std::function<void()> work, tell;
  };
  void push(Job job);
  void run();
  [[nodiscard]] static Error noMemory() { return {ErrorCode::kSystem, "memory", {}, {}}; }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Lists: the thread hands one on without memory, for nobody would take its exception.
  std::list<Job> waiting_;  ///< The first is being worked on.
  std::list<Job> finished_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace hapticd
