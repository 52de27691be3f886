#include "daemon/leash/builder_leash.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <list>
#include <new>
#include <optional>
#include <utility>

#include "daemon/ipc/builder_protocol.h"
#include "daemon/leash/spawn.h"
#include "daemon/leash/turns.h"
#include "daemon/log/log.h"

namespace hapticd {
namespace {

constexpr std::size_t kMostNotes = 32;
constexpr std::uint32_t kMostFrames = 4096;               ///< Of one job; an honest one has some hundred.
constexpr std::int64_t kFirstPause_ns = 50'000'000;       ///< Before a restart; doubles with each crash in a row ...
constexpr std::int64_t kLongestPause_ns = 2'000'000'000;  ///< ... up to this.

constexpr const char* kBroken = "the builder broke its protocol";

std::int64_t now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

Error builderFailed(std::string where, std::string what, std::string remedy = {}) {
  return {ErrorCode::kBuilderFailed, std::move(where), std::move(what), std::move(remedy)};
}

std::string howItEnded(int status) {
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    const char* const name = ::sigabbrev_np(number);
    return fmt::format("the builder died of signal {} (SIG{})", number, name == nullptr ? "?" : name);
  }
  return fmt::format("the builder ended with status {}", WEXITSTATUS(status));
}

/** Codes that a builder may give; what else it says is its own failure. */
ErrorCode allowedCode(std::uint32_t code) {
  switch (static_cast<ErrorCode>(code)) {
    case ErrorCode::kBadMesh:
    case ErrorCode::kCancelled:
    case ErrorCode::kPermissionDenied:
    case ErrorCode::kInvalidArgument:
    case ErrorCode::kUnsupported:
    case ErrorCode::kSystem:
    case ErrorCode::kInternal:
      return static_cast<ErrorCode>(code);
    default:
      return ErrorCode::kBuilderFailed;
  }
}

struct Job {
  std::uint64_t number = 0;
  std::uint64_t client = 0;
  UniqueFd upload;
  bool begun = false;    ///< The builder has said so.
  bool retried = false;  ///< The builder before died before it began.
};

}  // namespace

struct BuilderLeash::State {
  explicit State(BuilderOptions o) : options(std::move(o)) {}
  ~State() { endBuilder(); }

  Result<void> prepare();
  Result<void> spawn();
  /** Kills and reaps whatever runs. */
  void endBuilder();
  /** It shall end, for that reason if there is one; whatever it still says counts no more. */
  void condemn(std::string why);
  /** The builder is gone: fails the job it ran. */
  void lose(std::string why);
  void receive();
  void loseResult();
  void handle(BuilderFrame& frame);
  void checkEnd();
  void checkTime();
  void startNext();
  void takeNext();
  /** The job under way is the next one's. */
  void goBack() noexcept;
  void finish(BuildReport report);
  void letGo(UniqueFd file) const {
    if (file.valid() && spent) spent(std::move(file));
  }
  void setAlarm();
  void watch(int fd) const;

  BuilderOptions options;
  UniqueFd epoll, timer;
  UniqueFd socket, process;  // of the running builder
  pid_t pid = 0;
  bool closed = false;      // its socket is, or it was condemned; wait for its end
  std::string doom;         // why it was condemned
  std::uint32_t heard = 0;  // frames since the last order
  bool spoke = false;       // the running builder has
  std::string trouble;      // what became of one that did not
  Turns<Job> waiting;
  Job running;                                // number 0: none
  std::optional<Turns<Job>::Place> way_back;  // of that one
  bool cancelled = false;
  std::int64_t deadline_ns = 0;
  std::vector<std::string> notes;
  UniqueFd volume;
  float fraction = 0;
  std::list<BuildReport> reports;
  std::function<void(UniqueFd)> spent;
  std::uint64_t last_job = 0;
  std::uint32_t starts = 0, crashes_in_row = 0;
  std::int64_t not_before_ns = 0;
};

Result<void> BuilderLeash::State::prepare() {
  epoll.reset(::epoll_create1(EPOLL_CLOEXEC));
  timer.reset(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  if (!epoll.valid() || !timer.valid()) return systemError("builder leash", "epoll or timerfd", errno);
  watch(timer.get());
  return {};
}

void BuilderLeash::State::watch(int fd) const {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = fd;
  ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd, &event);
}

Result<void> BuilderLeash::State::spawn() {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0)
    return systemError("builder", "socketpair", errno);
  UniqueFd ours(pair[0]), theirs(pair[1]);

  static_assert(kBuilderSocket == 3, "the first that spawnProgram() gives");
  const int fds[] = {theirs.get()};
  const auto child = spawnProgram(options.program, {std::to_string(options.memory_bytes)}, fds);
  if (!child) return child.error();
  pid = *child;
  closed = spoke = false;
  heard = 0;
  doom.clear();
  socket = std::move(ours);
  process.reset(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));  // glibc 2.36 lacks C linkage for it
  ++starts;
  if (!process.valid()) {
    const int number = errno;
    endBuilder();
    return systemError("builder", "pidfd_open", number);
  }
  watch(socket.get());
  watch(process.get());
  return {};
}

void BuilderLeash::State::endBuilder() {
  if (pid == 0) return;
  socket.reset();
  ::kill(pid, SIGKILL);
  while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
  }
  process.reset();
  pid = 0;
}

void BuilderLeash::State::finish(BuildReport report) {
  report.job = running.number;
  std::list<BuildReport> told;  // First: without memory for it the job stays, and ends by its time.
  told.push_back(std::move(report));
  letGo(std::move(running.upload));
  letGo(std::move(volume));
  running = {};
  notes.clear();
  fraction = 0;
  cancelled = false;
  reports.splice(reports.end(), told);
}

void BuilderLeash::State::condemn(std::string why) {
  doom = std::move(why);
  closed = true;
  if (pid == 0) return;  // It has ended; kill() would take that for everybody here.
  ::epoll_ctl(epoll.get(), EPOLL_CTL_DEL, socket.get(), nullptr);
  ::kill(pid, SIGKILL);  // If it is dying already, its exit status stays as it is.
}

void BuilderLeash::State::lose(std::string why) {
  if (running.number == 0) return;
  if (!running.begun && !running.retried && !cancelled && doom.empty()) {
    running.retried = true;
    goBack();
    return;
  }
  BuildReport report;
  report.kind = BuildReport::Kind::kFailed;
  report.error = cancelled ? Error{ErrorCode::kCancelled, "build", {}, {}}
                           : builderFailed("build", std::move(why), "the mesh may be at fault; others can go on");
  finish(std::move(report));
}

void BuilderLeash::State::receive() {
  while (socket.valid() && !closed) {
    BuilderFrame frame;
    const FrameIo got = receiveFrame(socket.get(), frame, true);
    if (got == FrameIo::kLater) return;
    if (++heard > kMostFrames) return condemn(kBroken);  // Else one that talks on could keep us here.
    switch (got) {
      case FrameIo::kOk:
        spoke = true;
        trouble.clear();
        handle(frame);
        break;
      case FrameIo::kNoDescriptor:
        loseResult();
        break;
      case FrameIo::kBad:
      case FrameIo::kLater:
        return condemn(kBroken);
      case FrameIo::kClosed:
        return condemn({});  // Its end follows, or is made to.
    }
  }
}

/** What was built did not come through, and that is not the builder's fault. */
void BuilderLeash::State::loseResult() {
  if (running.number == 0) return;
  BuildReport report;
  report.kind = BuildReport::Kind::kFailed;
  report.error = cancelled ? Error{ErrorCode::kCancelled, "build", {}, {}} : systemError("build", "recvmsg", EMFILE);
  finish(std::move(report));
}

void BuilderLeash::State::handle(BuilderFrame& frame) {
  if (running.number == 0 || frame.head.job != running.number) return letGo(std::move(frame.fd));  // given up
  running.begun = true;
  BuildReport report;
  switch (frame.head.kind) {
    case BuilderFrameKind::kProgress:
      report.kind = BuildReport::Kind::kProgress;
      report.job = running.number;
      fraction = std::clamp(frame.head.fraction >= fraction ? frame.head.fraction : fraction, 0.0f, 1.0f);
      report.fraction = fraction;
      report.stage = log::printable(frame.text[0]);
      if (!reports.empty() && reports.back().kind == BuildReport::Kind::kProgress) reports.pop_back();  // overtaken
      reports.push_back(std::move(report));
      return;
    case BuilderFrameKind::kNote:
      if (notes.size() < kMostNotes) notes.push_back(log::printable(frame.text[0]));
      return;
    case BuilderFrameKind::kVolume:
      if (!frame.fd.valid() || volume.valid()) break;
      volume = std::move(frame.fd);
      return;
    case BuilderFrameKind::kDone:
      if (!frame.fd.valid()) break;
      crashes_in_row = 0;
      if (cancelled) {  // It crossed our word.
        letGo(std::move(frame.fd));
        return lose({});
      }
      report.kind = BuildReport::Kind::kDone;
      report.snapshot = std::move(frame.fd);
      report.volume = std::move(volume);
      report.stats = frame.head.stats;
      report.notes = std::move(notes);
      return finish(std::move(report));
    case BuilderFrameKind::kFailed:
      report.kind = BuildReport::Kind::kFailed;
      report.error = {allowedCode(frame.head.error), log::printable(frame.text[0]), log::printable(frame.text[1]),
                      log::printable(frame.text[2])};
      crashes_in_row = 0;
      return finish(std::move(report));
    default:
      break;
  }
  letGo(std::move(frame.fd));
  condemn(kBroken);
}

void BuilderLeash::State::checkEnd() {
  if (pid == 0) return;
  // WNOWAIT: until it is reaped its pid cannot be another process's, and receive() may still kill it.
  siginfo_t info{};
  if (::waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != pid) return;
  receive();  // what it said before
  int status = 0;
  if (::waitpid(pid, &status, 0) != pid) return;
  socket.reset();  // First of all: what follows may have no memory.
  process.reset();
  pid = 0;
  const std::int64_t pause = std::min(kLongestPause_ns, kFirstPause_ns << std::min(crashes_in_row, 10u));
  ++crashes_in_row;
  not_before_ns = now() + pause;
  const std::string why = doom.empty() ? howItEnded(status) : doom;
  log::warn("{}", why);
  if (!spoke && !cancelled) trouble = why;
  lose(why);
}

void BuilderLeash::State::checkTime() {
  std::uint64_t expirations = 0;
  (void)!::read(timer.get(), &expirations, sizeof expirations);
  if (running.number == 0 || pid == 0 || closed || now() < deadline_ns) return;
  condemn(fmt::format("the build took longer than {:.3g} s", static_cast<double>(options.job_timeout_ns) * 1e-9));
}

void BuilderLeash::State::takeNext() {
  way_back.emplace();
  std::list<Job> one;
  waiting.next(one);
  running = std::move(one.front());
}

void BuilderLeash::State::goBack() noexcept {
  const std::uint64_t client = running.client;
  waiting.pushFirst(client, std::exchange(running, {}), std::move(*way_back));
  way_back.reset();
}

void BuilderLeash::State::startNext() {
  if (running.number != 0 || waiting.empty()) return;
  if (pid == 0) {
    if (now() < not_before_ns) return;
    if (const auto spawned = spawn(); !spawned) {
      trouble = toString(spawned.error());
      log::error("{}", trouble);
      not_before_ns = now() + kLongestPause_ns;
      BuildReport report;
      report.kind = BuildReport::Kind::kFailed;
      report.error = spawned.error();
      takeNext();
      try {
        return finish(std::move(report));
      } catch (const std::bad_alloc&) {  // Told in the next attempt.
        return goBack();
      }
    }
  }
  if (closed) return;  // dying: the next builder takes it
  takeNext();
  deadline_ns = now() + options.job_timeout_ns;
  heard = 0;
  BuilderFrame order;
  order.head.kind = BuilderFrameKind::kBuild;
  order.head.job = running.number;
  if (sendFrame(socket.get(), order, running.upload.get(), true) != FrameIo::kOk) {
    // It died between two jobs: its end is reported next, and the job goes back for the builder after it.
    goBack();
    condemn({});
  }
}

void BuilderLeash::State::setAlarm() {
  std::int64_t at = 0;
  if (!reports.empty()) {
    at = 1;  // at once: fd() stays readable until next() has given everything
  } else if (running.number != 0) {
    if (!closed) at = deadline_ns;  // else it is dying: its end wakes us, not a deadline long past
  } else if (!waiting.empty() && pid == 0) {
    at = not_before_ns;
  }
  itimerspec alarm{};
  alarm.it_value.tv_sec = at / 1'000'000'000;
  alarm.it_value.tv_nsec = at % 1'000'000'000;
  ::timerfd_settime(timer.get(), TFD_TIMER_ABSTIME, &alarm, nullptr);
}

BuilderLeash::BuilderLeash(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}
BuilderLeash::~BuilderLeash() = default;

Result<std::unique_ptr<BuilderLeash>> BuilderLeash::start(const BuilderOptions& options) {
  auto state = std::make_unique<State>(options);
  if (const auto prepared = state->prepare(); !prepared) return prepared.error();
  if (const auto spawned = state->spawn(); !spawned) return spawned.error();
  return std::unique_ptr<BuilderLeash>(new BuilderLeash(std::move(state)));
}

int BuilderLeash::fd() const noexcept { return state_->epoll.get(); }
int BuilderLeash::pid() const noexcept { return state_->pid; }
std::uint32_t BuilderLeash::restarts() const noexcept { return state_->starts == 0 ? 0 : state_->starts - 1; }

const std::string& BuilderLeash::trouble() const noexcept { return state_->trouble; }

Result<std::uint64_t> BuilderLeash::submit(int upload_fd, std::uint64_t client) {
  auto copy = duplicate(upload_fd);
  if (!copy) return copy.error();
  const std::uint64_t number = ++state_->last_job;
  state_->waiting.push(client, {number, client, std::move(*copy)});
  state_->startNext();
  state_->setAlarm();
  return number;
}

void BuilderLeash::onSpent(std::function<void(UniqueFd)> close) { state_->spent = std::move(close); }

void BuilderLeash::cancel(std::uint64_t job) noexcept {
  State& s = *state_;
  if (s.running.number == job && job != 0) {
    if (s.cancelled) return;
    s.cancelled = true;
    BuilderFrame order;
    order.head.kind = BuilderFrameKind::kCancel;
    order.head.job = job;
    // A builder too busy to take the message is ended instead.
    if (sendFrame(s.socket.get(), order, -1, true) != FrameIo::kOk) s.condemn({});
    return;
  }
  std::list<Job> dropped;
  if (!s.waiting.take([job](const Job& waiting) { return waiting.number == job; }, dropped)) return;
  BuildReport report;
  report.kind = BuildReport::Kind::kFailed;
  report.job = job;
  report.error = {ErrorCode::kCancelled, "build", {}, {}};
  try {
    s.reports.push_back(std::move(report));
  } catch (const std::bad_alloc&) {  // Whoever has cancelled it knows.
  }
  s.setAlarm();
}

bool BuilderLeash::next(BuildReport& report) {
  State& s = *state_;
  if (s.reports.empty()) {
    s.receive();
    s.checkEnd();
    if (s.pid == 0) s.lose("the builder ended");  // For what had no memory to be told then.
    s.checkTime();
    s.startNext();
  }
  const bool have = !s.reports.empty();
  if (have) {
    report = std::move(s.reports.front());
    s.reports.pop_front();
  }
  s.setAlarm();
  return have;
}

}  // namespace hapticd
