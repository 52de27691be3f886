/** @file
 * A daemon whose configured devices open, or do not, as a test has it.
 */
#pragma once

#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>

#include "tests/session/bench.h"
#include "tests/session/still_device.h"

namespace hapticd::test {

/** What stands behind a URI. */
struct Socket {
  std::mutex mutex;
  std::condition_variable changed;
  bool there = true, hangs = false;
  int opened = 0, closed = 0, answers = 0;
  std::vector<std::int64_t> tried_ns;

  void set(bool now_there, bool now_hangs = false) {
    const std::lock_guard lock(mutex);
    there = now_there;
    hangs = now_hangs;
    changed.notify_all();
  }
};

class Plugged final : public StillDevice {
 public:
  Plugged(Socket& socket, std::string uri, const std::atomic<std::int64_t>& now_ns)
      : StillDevice("plugged", std::move(uri)), socket_(socket), now_ns_(now_ns) {}
  Result<void> open() override {
    std::unique_lock lock(socket_.mutex);
    socket_.tried_ns.push_back(now_ns_.load());
    socket_.changed.wait(lock, [&] { return !socket_.hangs; });
    ++socket_.answers;
    if (!socket_.there) return silence();
    ++socket_.opened;
    return {};
  }
  void giveUp() noexcept override { socket_.set(false); }
  void close() noexcept override { ++socket_.closed; }

 private:
  Socket& socket_;
  const std::atomic<std::int64_t>& now_ns_;
};

class Missing : public ::testing::Test {
 protected:
  static GroupConfig group(std::string name, std::vector<std::string> devices) {
    GroupConfig made;
    made.name = std::move(name);
    made.devices = std::move(devices);
    made.rate_hz = 2000;
    return made;
  }
  void make(std::vector<GroupConfig> groups, bool required = false) {
    CoreOptions options;
    options.config = Bench::relaxed();
    options.config.groups = std::move(groups);
    options.config.devices = limits;
    options.threads = false;
    options.epoch = 42;
    options.devices_required = required;
    core = std::make_unique<Core>(options, clock);
    core->devices().setFactory([this](std::string_view text) -> Result<std::unique_ptr<Device>> {
      if (text.empty() && !attached.empty()) text = attached.front();  // Any: the first that is there.
      const auto name = stands_for.find(std::string(text));
      const auto at = sockets.find(name == stands_for.end() ? std::string(text) : name->second);
      if (at == sockets.end()) return Error{ErrorCode::kNotFound, std::string(text), "nothing has that name", {}};
      return std::unique_ptr<Device>(std::make_unique<Plugged>(at->second, at->first, now_ns));
    });
    core->devices().setFinder([this] {
      std::vector<DeviceFound> found;
      for (const char* uri : attached) found.push_back({.info = {}, .real = true}), found.back().info.uri = uri;
      return found;
    });
    administration = *core->connect(101, 0, true);
  }
  /** With a first attempt at each group. */
  Result<void> start() {
    const auto begun = core->openConfigured([] { return false; });
    if (begun) settle();
    return begun;
  }
  void settle() {
    do core->poll();
    while (core->devices().opening() != 0 || !core->wanted().settled());
  }
  /** Polls, with the clock at rest while something is being opened, until then. */
  void until(std::int64_t t_ns) {
    while (clock.now() < t_ns || core->devices().opening() != 0) {
      core->poll();
      if (core->devices().opening() == 0) clock.advance(5 * kMs);
      now_ns = clock.now();
    }
  }
  std::vector<std::string> open() {
    std::vector<std::string> all;
    for (const auto& device : core->devices().devices()) all.push_back(device->info().uri);
    return all;
  }
  /** Polls for 2 ms, in which nothing is to happen. */
  void linger() {
    for (int i = 0; i < 20; ++i) core->poll(), ::usleep(100);
  }
  /** Whether its opening has begun, or has ended. */
  bool tried(const char* uri) {
    const std::lock_guard lock(sockets[uri].mutex);
    return !sockets[uri].tried_ns.empty();
  }
  bool answered(const char* uri) {
    const std::lock_guard lock(sockets[uri].mutex);
    return sockets[uri].answers > 0;
  }
  std::vector<std::string> absent() {
    std::vector<std::string> all;
    for (const auto& one : core->wanted().absent()) all.push_back(one.uri);
    return all;
  }

  ManualClock clock{0};
  std::atomic<std::int64_t> now_ns{0};    ///< As the clock, for the threads that open devices.
  std::map<std::string, Socket> sockets;  // before the core: its devices go first
  std::vector<const char*> attached;
  std::vector<DeviceConfig> limits;
  std::map<std::string, std::string> stands_for;  ///< What other texts mean: the URI of a device that is plugged in.
  std::unique_ptr<Core> core;
  std::uint64_t administration = 0;
};

}  // namespace hapticd::test
