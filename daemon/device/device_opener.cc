#include "daemon/device/device_opener.h"

#include <pthread.h>

#include <exception>
#include <new>
#include <system_error>

#include "daemon/device/patience.h"
#include "drivers/link/slow_to_open.h"

namespace hapticd {
namespace {

/** With no text that would need some. */
Error noMemory() { return {ErrorCode::kSystem, "memory", {}, {}}; }

}  // namespace

void DeviceOpener::start(std::unique_ptr<Device> device, Done done) {
  std::list<Running> one(1);
  Running& running = one.front();
  running.uri = device->info().uri;
  running.device = std::move(device);
  running.done = std::move(done);
  running_.splice(running_.end(), one);  // Only now: one that never begins would never end.
  const auto open = [&running] {
    ::pthread_setname_np(::pthread_self(), "device-open");
    try {
      running.result = running.device->open();
    } catch (const std::bad_alloc&) {
      running.result = noMemory();
    } catch (const std::exception& e) {  // drivers' libraries may throw; nobody is above us
      running.result = Error{ErrorCode::kInternal, running.device->info().uri, e.what(), {}};
    }
    running.finished.store(true, std::memory_order_release);  // R, pairs with A in poll() and stop()
  };
  try {
    try {
      running.thread = std::thread(open);
    } catch (const std::system_error& e) {  // no more threads for this user or service
      running.result = Error{ErrorCode::kSystem, running.uri, std::string("no thread can be started: ") + e.what(),
                             "raise TasksMax= or the user's nproc"};
      running.finished.store(true);
    }
  } catch (const std::bad_alloc&) {
    running.result = noMemory();
    running.finished.store(true);
  }
}

void DeviceOpener::poll() {
  for (auto it = running_.begin(); it != running_.end();) {
    if (!it->finished.load(std::memory_order_acquire)) {  // A
      ++it;
      continue;
    }
    if (it->thread.joinable()) it->thread.join();
    Running& running = *it;
    Opened opened = running.result ? Opened(std::move(running.device)) : Opened(running.result.error());
    const Done done = std::move(running.done);
    it = running_.erase(it);
    done(std::move(opened));  // May start another.
  }
}

DeviceOpener::~DeviceOpener() {
  giveUp();
  for (Running& running : running_) {
    if (running.thread.joinable()) running.thread.join();
    if (running.result) running.device->close();
  }
}

void DeviceOpener::giveUp() {
  for (Running& running : running_) {
    if (auto* const slow = dynamic_cast<SlowToOpen*>(running.device.get())) slow->giveUp();
  }
}

DeviceOpener::Stopped DeviceOpener::stop(std::int64_t patience_ns) {
  giveUp();
  Stopped stopped;
  MonotonicClock clock;
  Patience patience(clock, patience_ns);
  for (auto it = running_.begin(); it != running_.end();) {
    if (!patience.until([&] { return it->finished.load(std::memory_order_acquire); })) {  // A
      stopped.stuck.push_back((it++)->uri);
      continue;
    }
    if (it->thread.joinable()) it->thread.join();
    if (it->result) stopped.open.push_back(std::move(it->device));
    it = running_.erase(it);
  }
  return stopped;
}

}  // namespace hapticd
