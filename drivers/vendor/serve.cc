#include "drivers/vendor/serve.h"

#include <poll.h>
#include <unistd.h>

#include <cstdint>
#include <thread>

#include "drivers/registry.h"
#include "drivers/vendor/helper_device.h"
#include "drivers/vendor/helper_protocol.h"
#include "drivers/vendor/vendor_driver.h"
#include "rt/cycle/realtime.h"

namespace hapticd {
namespace {

constexpr std::int64_t kService_ns = 20'000'000;  ///< Longest stay in one exchange().
constexpr int kServeLook_ms = 20;
constexpr int kHung_ms = 1000;  ///< A library that does not come back for so long is dead.
constexpr int kPriority = 85;
constexpr std::size_t kServeStackBytes = 1024 * 1024;

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
  for (int still_ms = 0; still_ms < kHung_ms && !stop.load() && !running.ended.load(); still_ms += kServeLook_ms) {
    pollfd look{socket, POLLIN, 0};
    if (::poll(&look, 1, kServeLook_ms) > 0) return;  // The daemon says nothing more: it has hung up.
    if (running.beat.load() != beat) still_ms = 0;
    beat = running.beat.load();
  }
}

/**
 * While it stands, a library is opening its device. If it has not come back `patience_ms` after the daemon has hung up
 * it never will: the process ends, which systemd would keep otherwise, and the device with it.
 */
class Opening {
 public:
  Opening(int socket, int patience_ms) : thread_([this, socket, patience_ms] { watch(socket, patience_ms); }) {}
  ~Opening() {
    done_.store(true);
    thread_.join();
  }
  Opening(const Opening&) = delete;
  Opening& operator=(const Opening&) = delete;

 private:
  void watch(int socket, int patience_ms) const {
    bool alone = false;
    for (int alone_ms = 0; !done_.load(); alone_ms += alone ? kServeLook_ms : 0) {
      pollfd look{socket, POLLIN, 0};  // The daemon says nothing more: whatever comes is its end.
      alone = alone || ::poll(&look, 1, kServeLook_ms) > 0;
      if (alone) (void)::poll(nullptr, 0, kServeLook_ms);
      if (alone_ms >= patience_ms) ::_exit(3);
    }
  }

  std::atomic<bool> done_{false};
  std::thread thread_;
};

}  // namespace

int serveVendor(int socket, const std::atomic<bool>& stop, int patience_ms) {
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
    const Opening opening(socket, patience_ms);
    answer.opened = io->open(stop);
    answer.info = io->info();
  }
  if (!answer.opened) {
    if (io) io->close();
    (void)sendAnswer(socket, answer);
    return 1;
  }
  (void)lockMemory();
  SharedDeviceEnd link(*mapping.get(), request.value().generation, kCommandLife_ns);
  Running running;
  RtThread thread;
  const auto started = thread.start("vendor-io", kServeStackBytes, [&] {
    (void)becomeRealtime(kPriority);  // Without the right to it, it runs as others do.
    drive(*io, *mapping.get(), link, clock, running);
  });
  if (!started) answer.opened = started;
  if (!sendAnswer(socket, answer) || !started) running.stop.store(true);
  if (started) watch(socket, stop, running);
  running.stop.store(true);
  for (int waited_ms = 0; started && !running.ended.load(); waited_ms += kServeLook_ms) {
    if (waited_ms >= kHung_ms / 4) ::_exit(3);  // Its thread is in the library and does not come back.
    (void)::poll(nullptr, 0, kServeLook_ms);
  }
  thread.join();
  io->close();
  return 0;
}

}  // namespace hapticd
