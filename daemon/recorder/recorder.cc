#include "daemon/recorder/recorder.h"

#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <new>
#include <system_error>

#include "daemon/ipc/snapshot_memory.h"
#include "rt/base/clock.h"

namespace hapticd {
namespace {

constexpr std::chrono::milliseconds kRound{10};

}  // namespace

Result<std::unique_ptr<Recorder>> Recorder::create(bool lock) {
  std::unique_ptr<Recorder> out(new Recorder);
  auto file = Memfd::create("hapticd-log", sizeof(CycleLog));
  if (!file) return file.error();
  auto memory = file->map(Memfd::Access::kWrite);
  if (!memory) return memory.error();
  if (lock) {
    if (auto r = memory->lock(); !r) return r.error();
  }
  out->log_memory_ = std::move(*memory);
  out->log_ = new (out->log_memory_.data()) CycleLog;
  out->cycle_ = std::make_unique<RecordedCycle>();
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    return systemError("recording", "socketpair", errno);
  out->stream_.reset(ends[0]);
  out->reader_end_.reset(ends[1]);
  (void)::shutdown(ends[0], SHUT_RD);
  try {
    out->thread_ = std::thread([recorder = out.get()] { recorder->run(); });
  } catch (const std::system_error& e) {
    return Error{ErrorCode::kSystem, "recording", std::string("no thread can be started: ") + e.what(),
                 "raise TasksMax= or the user's nproc"};
  }
  pthread_setname_np(out->thread_.native_handle(), "recorder");
  return out;
}

Recorder::~Recorder() {
  abandon_.store(true, std::memory_order_relaxed);
  finish("abandoned");
  if (thread_.joinable()) thread_.join();
  if (log_ != nullptr) log_->~CycleLog();
}

void Recorder::begin(RecordingHeader header, std::vector<Mesh> meshes, std::vector<Texture> textures) {
  const std::lock_guard lock(mutex_);
  header.meshes = static_cast<std::uint32_t>(meshes.size());
  meshes_ = std::move(meshes);
  textures_ = std::move(textures);
  header_ = std::move(header);
  changed_.notify_one();
}

void Recorder::add(Mesh mesh) {
  const std::lock_guard lock(mutex_);
  mesh.after = log_->pushed();
  meshes_.push_back(std::move(mesh));
}

void Recorder::add(PublishedTexture texture) {
  const std::lock_guard lock(mutex_);
  textures_.push_back({log_->pushed(), std::move(texture)});
}

void Recorder::finish(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (!reason_) {
    reason_ = reason;
    finished_ns_.store(MonotonicClock().now(), std::memory_order_relaxed);
  }
  changed_.notify_one();
}

void Recorder::run() noexcept {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return header_ || reason_; });
    if (!header_) return done_.store(true, std::memory_order_release);
  }
  try {
    record();
  } catch (...) {               // This thread's last frame; only bad_alloc can come.
    end_.reason = "no memory";  // Short enough to need none.
    end_.lost = lostAfter(end_.cycles);
  }
  (void)::shutdown(stream_.get(), SHUT_RDWR);
  done_.store(true, std::memory_order_release);
}

/** Of all that the servo has run since: what found no room in the log, and what was left there. */
std::uint64_t Recorder::lostAfter(std::uint64_t cycles) const {
  const std::uint64_t all = log_->pushed() + log_->lost();
  return all - std::min(all, cycles);  // A servo that died may have counted its last less than it gave it.
}

void Recorder::record() {
  RecordingWriter writer([this](std::span<const std::byte> bytes) { return send(bytes); });
  MonotonicClock clock;
  bool going = writer.header(*header_);
  std::int64_t flushed_ns = clock.now();
  std::string reason;
  while (going) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kRound, [this] { return reason_.has_value(); });
      if (reason_) reason = *reason_;
    }
    // Whether the log has ended is read before draining it, so that its last entries are drained as well.
    const bool last = !reason.empty() || log_->lost() != 0;
    going = drain(writer);
    end_.cycles = writer.cycles();
    if (going && clock.now() - flushed_ns >= kFlushNs) {
      going = writer.flush();
      flushed_ns = clock.now();
    }
    if (last) break;
  }
  going = going && writer.flush();
  if (log_->lost() != 0) reason = "the reader of the recording was too slow";
  if (!going) reason = "the reader of the recording has gone or stands still";
  end_ = {reason, writer.cycles(), lostAfter(writer.cycles())};
  (void)writer.end(reason, end_.lost);
}

/** Meshes and textures that the next cycle may use. */
bool Recorder::writeDue(RecordingWriter& writer) {
  const auto takeDue = [this](auto& waiting) {
    std::remove_reference_t<decltype(waiting)> due;
    const std::lock_guard lock(mutex_);
    while (!waiting.empty() && waiting.front().after <= taken_) {
      due.push_back(std::move(waiting.front()));
      waiting.erase(waiting.begin());
    }
    return due;
  };
  for (Mesh& mesh : takeDue(meshes_)) {
    if (mesh.open) closeDeformed(mesh.copy);
    if (!writer.mesh(mesh.entry, mesh.bytes())) return false;
  }
  for (const Texture& due : takeDue(textures_)) {
    if (!writer.texture(due.texture.entry, *due.texture.memory->view())) return false;
  }
  return true;
}

/**
 * What the log holds, and before each cycle what it may use: looked for once the cycle is there, for what it may use
 * was added before it came.
 */
bool Recorder::drain(RecordingWriter& writer) {
  LoggedCycle cycle;
  std::array<Command, kMaxCommandsPerCycle> commands;
  while (true) {
    const bool more = log_->pop(cycle, commands);
    if (!writeDue(writer)) return false;
    if (!more) return writer.good();
    ++taken_;
    restore(cycle, commands, cycle_->input, cycle_->sent);
    if (!writer.cycle(*cycle_)) return false;
  }
}

bool Recorder::send(std::span<const std::byte> bytes) {
  MonotonicClock clock;
  std::int64_t moved_ns = clock.now();
  const auto enough = [&] {
    const std::int64_t finished_ns = finished_ns_.load(std::memory_order_relaxed), now_ns = clock.now();
    return now_ns - moved_ns > kPatienceNs || (finished_ns != 0 && now_ns - finished_ns > kPatienceNs);
  };
  while (!bytes.empty()) {
    const ssize_t sent = ::send(stream_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
      moved_ns = clock.now();
      continue;
    }
    if (errno != EAGAIN && errno != EINTR) return false;
    if (abandon_.load(std::memory_order_relaxed) || enough()) return false;
    pollfd writable{stream_.get(), POLLOUT, 0};
    (void)::poll(&writable, 1, 50);
  }
  return true;
}

}  // namespace hapticd
