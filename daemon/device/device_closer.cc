#include "daemon/device/device_closer.h"

#include <pthread.h>

#include <algorithm>
#include <exception>
#include <new>

#include "daemon/device/patience.h"

namespace hapticd {

DeviceCloser::~DeviceCloser() {
  for (Closing& closing : closing_) {
    if (closing.thread.joinable()) closing.thread.join();
  }
}

std::vector<std::string> DeviceCloser::close(DeviceGroup::Leaving leaving, std::int64_t patience_ns) {
  for (const auto& device : leaving.devices) device->safe();
  std::list<Closing> one;
  try {
    one.emplace_back();
    for (const auto& device : leaving.devices) one.front().uris.push_back(device->info().uri);
  } catch (const std::bad_alloc&) {  // Then here.
    for (const auto& device : leaving.devices) device->close();
    return {};
  }
  closing_.splice(closing_.end(), one);
  Closing& closing = closing_.back();
  closing.group = std::move(leaving);
  const auto close_all = [&closing] {
    for (const auto& device : closing.group.devices) {
      device->close();
      closing.closed.fetch_add(1, std::memory_order_release);  // R, pairs with A
    }
  };
  try {
    closing.thread = std::thread([close_all] {
      ::pthread_setname_np(::pthread_self(), "device-close");
      close_all();
    });
  } catch (const std::exception&) {  // No more threads, or no memory for one: then here.
    close_all();
  }
  MonotonicClock clock;
  Patience patience(clock, patience_ns);
  const auto closed = [&closing] { return closing.closed.load(std::memory_order_acquire); };  // A
  if (!patience.until([&] { return closed() == closing.uris.size(); }))
    return {closing.uris.begin() + static_cast<std::ptrdiff_t>(closed()), closing.uris.end()};
  if (closing.thread.joinable()) closing.thread.join();
  closing_.pop_back();
  return {};
}

std::vector<std::string> DeviceCloser::poll() {
  std::vector<std::string> closed;
  for (auto it = closing_.begin(); it != closing_.end();) {
    if (it->closed.load(std::memory_order_acquire) < it->uris.size()) {  // A
      ++it;
      continue;
    }
    if (it->thread.joinable()) it->thread.join();
    closed.insert(closed.end(), it->uris.begin(), it->uris.end());
    it = closing_.erase(it);
  }
  return closed;
}

bool DeviceCloser::has(std::string_view uri) const {
  const auto here = [uri](const Closing& c) { return std::find(c.uris.begin(), c.uris.end(), uri) != c.uris.end(); };
  return std::any_of(closing_.begin(), closing_.end(), here);
}

std::vector<std::string> DeviceCloser::names() const {
  std::vector<std::string> all;
  for (const Closing& closing : closing_) all.insert(all.end(), closing.uris.begin(), closing.uris.end());
  return all;
}

}  // namespace hapticd
