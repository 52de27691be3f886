#include "tools/haptic-bench/load/levels.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <hapticclient/hapticclient.hpp>
#include <thread>

#include "daemon/ipc/unique_fd.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/load/connect.h"
#include "tools/haptic-bench/load/stroke.h"

namespace haptic_bench {
namespace {

using SteadyClock = std::chrono::steady_clock;
using std::chrono::microseconds;

void drawFrames(const std::string& socket) {
  haptic::Client client = connectTo(socket);
  haptic::Session session = check(client.openSession());
  constexpr microseconds kFrame{16'667}, kDrawn{12'500};
  std::vector<float> pixels(1920 * 1080);
  for (auto next = SteadyClock::now();; std::this_thread::sleep_until(next += kFrame)) {
    const auto sample = session.latest();
    auto shade = sample ? static_cast<float>(sample->p[2]) : 0.0f;
    while (SteadyClock::now() < next + kDrawn) {
      for (float& pixel : pixels) pixel = shade += 1e-3f * pixel;
    }
  }
}

void uploadMeshes(const std::string& socket) {
  haptic::Client client = connectTo(socket);
  const Model model = tessellate({0.01, 0.1}, 64'000);
  for (;;) {
    auto mesh = client.scene().upload({model.vertices.data()->data(), 3 * model.vertices.size()},
                                      {model.triangles.data()->data(), 3 * model.triangles.size()});
    if (mesh) (void)client.scene().dropMesh((*mesh)->id);
  }
}

void pushAtServoRate(const std::string& socket) {
  haptic::Client client = connectTo(socket);
  haptic::Session session = check(client.openSession());
  haptic_client_force none{};
  none.lease_ns = 100'000'000;
  for (auto next = SteadyClock::now();; std::this_thread::sleep_until(next += microseconds(1000))) {
    (void)session.latest();
    (void)session.push(none, {.latest = true});
  }
}

void writeToDisk(const std::string& folder) {
  const std::vector<char> block(4 << 20, 'x');
  std::string path = folder + "/haptic-bench-load.XXXXXX";
  const hapticd::UniqueFd file(mkostemp(path.data(), O_CLOEXEC));
  constexpr const char* kRemedy = "64 MB of room on a disk; TMPDIR names another folder";
  if (!file.valid()) throw Failure(path, std::strerror(errno), kRemedy);
  unlink(path.c_str());
  const auto size = static_cast<ssize_t>(block.size());
  for (off_t at = 0;; at = (at + 1) % 16) {
    if (pwrite(file.get(), block.data(), block.size(), at * size) == size && fdatasync(file.get()) == 0) continue;
    throw Failure(path, std::strerror(errno), kRemedy);
  }
}

[[noreturn]] void spin() {
  std::atomic<std::uint64_t> turns{0};
  for (;;) turns.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

const char* nameOf(Level level) {
  constexpr const char* kNames[] = {"idle", "graphics", "uploads", "clients", "disk", "busy"};
  return kNames[static_cast<std::size_t>(level)];
}

std::string folderOnDisk(const std::string& folder) {
  struct statfs where {};
  const bool in_memory = statfs(folder.c_str(), &where) == 0 && where.f_type == TMPFS_MAGIC;
  return in_memory ? "/var/tmp" : folder;
}

std::vector<Child> startLoad(Level level, const std::string& socket, const std::string& folder) {
  std::vector<Child> children;
  const auto start = [&](long count, const std::function<void()>& body) {
    for (; count > 0; --count) children.emplace_back(body);
  };
  switch (level) {
    case Level::kIdle:
      break;
    case Level::kGraphics:
      start(1, [&] { drawFrames(socket); });
      break;
    case Level::kUploads:
      start(1, [&] { uploadMeshes(socket); });
      break;
    case Level::kClients:
      start(4, [&] { pushAtServoRate(socket); });
      break;
    case Level::kDisk:
      start(1, [&] { writeToDisk(folderOnDisk(folder)); });
      break;
    case Level::kBusy:
      start(sysconf(_SC_NPROCESSORS_ONLN), spin);
      break;
  }
  return children;
}

}  // namespace haptic_bench
