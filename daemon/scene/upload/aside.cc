#include "daemon/scene/upload/aside.h"

#include <pthread.h>

#include <system_error>

#include "daemon/log/log.h"

namespace hapticd {

Aside::~Aside() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Aside::push(Job job) {
  if (!thread_.joinable()) {
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& e) {  // Then here: late is better than never.
      log::warn("no thread can be started for what takes long: {} (raise TasksMax= or the user's nproc)", e.what());
      job.work();
      const std::lock_guard lock(mutex_);
      finished_.push_back(std::move(job));
      return;
    }
  }
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(job));
  }
  changed_.notify_all();
}

void Aside::run() {
  ::pthread_setname_np(::pthread_self(), "aside");
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
    if (stopping_) return;
    const Job& job = waiting_.front();  // It stays there until it is done.
    lock.unlock();
    job.work();
    lock.lock();
    finished_.splice(finished_.end(), waiting_, waiting_.begin());
  }
}

void Aside::poll() {
  for (;;) {
    std::list<Job> told;
    {
      const std::lock_guard lock(mutex_);
      if (finished_.empty()) return;
      told.splice(told.end(), finished_, finished_.begin());
    }
    told.front().tell();  // May start another; if it throws the others come with the next poll().
  }
}

std::size_t Aside::size() const {
  const std::lock_guard lock(mutex_);
  return waiting_.size() + finished_.size();
}

}  // namespace hapticd
