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

void Aside::push(Job job, std::uint64_t client) {
  if (!thread_.joinable()) {
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& e) {  // Then here: late is better than never.
      log::warn("no thread can be started for what takes long: {} (raise TasksMax= or the user's nproc)", e.what());
      job.work(false);
      const std::lock_guard lock(mutex_);
      finished_.push_back(std::move(job));
      return;
    }
  }
  {
    const std::lock_guard lock(mutex_);
    waiting_.push(client, std::move(job));
  }
  changed_.notify_all();
}

void Aside::cancel(std::uint64_t number) {
  {
    const std::lock_guard lock(mutex_);
    if (!waiting_.take([&](const Job& job) { return job.number == number; }, dropped_)) return;
  }
  changed_.notify_all();
}

void Aside::run() {
  ::pthread_setname_np(::pthread_self(), "aside");
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stopping_ || !waiting_.empty() || !dropped_.empty(); });
    if (stopping_) return;
    const bool dropped = !dropped_.empty();  // First: it only gives memory back.
    if (dropped) {
      begun_.splice(begun_.end(), dropped_, dropped_.begin());
    } else {
      waiting_.next(begun_);
    }
    const Job& job = begun_.front();
    lock.unlock();
    job.work(dropped);
    lock.lock();
    finished_.splice(finished_.end(), begun_);
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
  return waiting_.size() + dropped_.size() + begun_.size() + finished_.size();
}

}  // namespace hapticd
