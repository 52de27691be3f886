#include "daemon/device/device_opener.h"

#include <pthread.h>

#include <exception>
#include <system_error>

#include "drivers/link/slow_to_open.h"

namespace hapticd {

void DeviceOpener::start(std::unique_ptr<Device> device, Done done) {
  Running& running = running_.emplace_back();
  running.device = std::move(device);
  running.done = std::move(done);
  const auto open = [&running] {
    ::pthread_setname_np(::pthread_self(), "device-open");
    try {
      running.result = running.device->open();
    } catch (const std::exception& e) {  // drivers' libraries may throw; nobody is above us
      running.result = Error{ErrorCode::kInternal, running.device->info().uri, e.what(), {}};
    }
    running.finished.store(true, std::memory_order_release);  // R, pairs with A in poll()
  };
  try {
    running.thread = std::thread(open);
  } catch (const std::system_error& e) {  // no more threads for this user or service
    running.result = Error{ErrorCode::kSystem, running.device->info().uri,
                           std::string("no thread can be started: ") + e.what(), "raise TasksMax= or the user's nproc"};
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

void DeviceOpener::stop() {
  for (Running& running : running_) {
    if (auto* const slow = dynamic_cast<SlowToOpen*>(running.device.get())) slow->giveUp();
  }
  for (Running& running : running_) {
    if (running.thread.joinable()) running.thread.join();
    if (running.result) running.device->close();
  }
  running_.clear();
}

}  // namespace hapticd
