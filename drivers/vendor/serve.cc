#include "drivers/vendor/serve.h"

#include <poll.h>
#include <unistd.h>

#include <cstdint>
#include <future>

#include "drivers/registry.h"
#include "drivers/vendor/helper_device.h"
#include "drivers/vendor/helper_protocol.h"
#include "drivers/vendor/vendor_driver.h"
#include "rt/cycle/realtime.h"

namespace hapticd {
namespace {

constexpr std::int64_t kStale_ns = 10'000'000;    ///< A servo silent for so long has its force taken back.
constexpr std::int64_t kService_ns = 20'000'000;  ///< Longest stay in one exchange().
constexpr int kLook_ms = 20;
constexpr int kHung_ms = 1000;  ///< A library that does not come back for so long is dead.
constexpr int kPriority = 85;
constexpr std::size_t kStackBytes = 1024 * 1024;

struct Running {
  std::atomic<bool> stop{false}, ended{false};
  std::atomic<std::uint64_t> beat{0};
};

void drive(DeviceIo& io, SharedLinkMemory& memory, SharedDeviceEnd& link, Clock& clock, Running& running) {
  while (!running.stop.load()) {
    memory.calibration.store(static_cast<std::uint32_t>(io.calibration()), std::memory_order_relaxed);
    if (!io.exchange(link, clock.now() + kService_ns)) {
      link.publishStatus(io.statusWhenGone());
      break;
    }
    running.beat.fetch_add(1);
  }
  running.ended.store(true);
}

/** Until there is a reason to end. */
void watch(int socket, const std::atomic<bool>& stop, const Running& running) {
  std::uint64_t beat = 0;
  for (int still_ms = 0; still_ms < kHung_ms && !stop.load() && !running.ended.load(); still_ms += kLook_ms) {
    pollfd look{socket, POLLIN, 0};
    if (::poll(&look, 1, kLook_ms) > 0) return;  // The daemon says nothing more: it has hung up.
    if (running.beat.load() != beat) still_ms = 0;
    beat = running.beat.load();
  }
}

}  // namespace

int serveVendor(int socket, const std::atomic<bool>& stop) {
  int descriptor = -1;
  const auto request = receiveRequest(socket, descriptor);
  SharedLinkMapping mapping;
  MonotonicClock clock;
  std::unique_ptr<DeviceIo> io;
  HelperAnswer answer;
  if (!request) {
    if (descriptor >= 0) ::close(descriptor);
    answer.opened = request.error();
  } else if (auto taken = mapping.take(descriptor); !taken) {
    answer.opened = taken;
  } else if (const auto uri = parseDeviceUri(request.value().uri); !uri) {
    answer.opened = uri.error();
  } else if (auto made = makeVendorIo(*uri, clock); !made) {
    answer.opened = made.error();
  } else {
    io = std::move(*made);
    answer.opened = io->open(stop);
    answer.info = io->info();
  }
  if (!answer.opened) {
    if (io) io->close();
    (void)sendAnswer(socket, answer);
    return 1;
  }
  (void)lockMemory();
  SharedDeviceEnd link(*mapping.get(), request.value().generation, kStale_ns);
  Running running;
  RtThread thread;
  const auto started = thread.start("vendor-io", kStackBytes, [&] {
    (void)becomeRealtime(kPriority);  // Without the right to it, it runs as others do.
    drive(*io, *mapping.get(), link, clock, running);
  });
  if (!started) answer.opened = started;
  if (!sendAnswer(socket, answer) || !started) running.stop.store(true);
  if (started) watch(socket, stop, running);
  running.stop.store(true);
  for (int waited_ms = 0; started && !running.ended.load(); waited_ms += kLook_ms) {
    if (waited_ms >= kHung_ms / 4) ::_exit(3);  // Its thread is in the library and does not come back.
    (void)::poll(nullptr, 0, kLook_ms);
  }
  thread.join();
  io->close();
  return 0;
}

}  // namespace hapticd
