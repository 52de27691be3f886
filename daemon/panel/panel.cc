#include "daemon/panel/panel.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <utility>

namespace hapticd {
namespace {

constexpr int kMostEdges = 16;
constexpr std::uint32_t kBlinkShows = 25;  ///< 2 Hz.

}  // namespace

std::vector<LineRequest> lineRequests(const std::vector<LineConfig>& config) {
  std::vector<LineRequest> requests;
  for (const LineConfig& line : config) {
    LineRequest request;
    request.chip = line.chip;
    request.name = line.name;
    request.output = line.role == "enable" || line.role == "heartbeat" || line.role == "led";
    request.active_low = line.active_low;
    if (line.bias == "pull-up") request.bias = LineBias::kPullUp;
    if (line.bias == "pull-down") request.bias = LineBias::kPullDown;
    if (line.bias == "none") request.bias = LineBias::kNone;
    requests.push_back(std::move(request));
  }
  return requests;
}

Panel::Panel(const std::vector<LineConfig>& config, std::unique_ptr<Lines> lines, SafetyLines& safety,
             std::int64_t now_ns)
    : lines_(std::move(lines)), safety_(safety) {
  constexpr std::string_view kRoles[] = {"stop", "deadman", "home", "enable", "heartbeat", "led"};
  std::uint32_t buttons = 0;
  for (std::size_t i = 0; i < config.size(); ++i) {
    const auto role =
        static_cast<Role>(std::find(std::begin(kRoles), std::end(kRoles), config[i].role) - std::begin(kRoles));
    const bool input = role == Role::kStop || role == Role::kDeadman || role == Role::kHome;
    const bool closed = input && lines_->get(i) == 1;
    line_.push_back({role, SafetyContact(std::llround(config[i].debounce_ms * 1e6), closed)});
    if (role == Role::kHome) ++buttons;
  }
  safety_.button_count.store(buttons, std::memory_order_relaxed);
  publish(now_ns);
}

Panel::~Panel() {
  end_.store(true, std::memory_order_relaxed);
  thread_.join();
  safety_.stop.store(true, std::memory_order_release);
  for (std::size_t i = 0; i < line_.size(); ++i) {
    if (line_[i].role >= Role::kEnable) (void)lines_->set(i, false);
  }
}

Result<void> Panel::start(int priority, bool allow_no_rt, Clock& clock) {
  std::promise<Result<void>> scheduled;
  auto answer = scheduled.get_future();
  auto started = thread_.start("gpio", std::size_t{256} * 1024, [this, priority, allow_no_rt, &clock, &scheduled] {
    prefaultStack(std::size_t{64} * 1024);
    Result<void> rights = becomeRealtime(priority);
    const bool go = rights.ok() || allow_no_rt;
    scheduled.set_value(std::move(rights));
    std::array<LineEdge, kMostEdges> edges;
    while (go && !end_.load(std::memory_order_relaxed) && !lost()) {
      const int count = lines_->wait(patience(clock.now()), edges.data(), kMostEdges);
      if (count == Lines::kLost) {
        lose();
      } else {
        step(clock.now(), edges.data(), count);
      }
    }
  });
  if (!started) return started;
  Result<void> rights = answer.get();
  return rights || allow_no_rt ? Result<void>() : rights;
}

std::int64_t Panel::patience(std::int64_t now_ns) const noexcept {
  std::int64_t due = std::min(next_show_ns_, now_ns + kLook_ns);
  for (const Line& line : line_) due = std::min(due, line.contact.due());
  return std::max<std::int64_t>(due - now_ns, 0);
}

void Panel::step(std::int64_t now_ns, const LineEdge* edges, int count) noexcept {
  if (lost()) return;
  for (int i = 0; i < count; ++i) see(edges[i].line, edges[i].active, now_ns);
  publish(now_ns);  // before anything that may take its time
  for (std::size_t i = 0; i < line_.size(); ++i) {
    if (line_[i].role >= Role::kEnable) continue;
    const int level = lines_->get(i);
    if (level == Lines::kLost) return lose();
    see(i, level == 1, now_ns);
  }
  publish(now_ns);
  show(now_ns);
}

void Panel::see(std::size_t line, bool active, std::int64_t now_ns) noexcept {
  if (line < line_.size()) line_[line].contact.see(active, now_ns);
}

void Panel::lose() noexcept {
  safety_.stop.store(true, std::memory_order_release);
  lost_.store(true, std::memory_order_release);
  for (std::size_t i = 0; i < line_.size(); ++i) {
    if (line_[i].role >= Role::kEnable) (void)lines_->set(i, false);
    line_[i].shown = false;
  }
}

void Panel::publish(std::int64_t now_ns) noexcept {
  bool stop = false;
  bool deadman = false;
  std::uint32_t pressed = 0;
  std::uint32_t bit = 1;
  for (Line& line : line_) {
    line.contact.pass(now_ns);
    const bool open = line.contact.open();
    if (line.role == Role::kStop) stop = stop || open;
    if (line.role == Role::kDeadman) deadman = deadman || open;
    if (line.role == Role::kHome) {
      pressed |= open ? 0 : bit;
      bit <<= 1;
    }
  }
  safety_.deadman_open.store(deadman, std::memory_order_release);
  safety_.buttons.store(pressed, std::memory_order_relaxed);
  safety_.stop.store(stop, std::memory_order_release);
  // R10, pairs with A10 in stopAt(): what it saw is told before that it looked.
  safety_.looked_ns.store(std::max<std::int64_t>(now_ns, 1), std::memory_order_release);
}

/** The enable line follows the servos; it falls at once with the stop. */
void Panel::show(std::int64_t now_ns) noexcept {
  const bool barred =
      safety_.stop.load(std::memory_order_relaxed) || safety_.deadman_open.load(std::memory_order_relaxed);
  if (barred) {
    for (std::size_t i = 0; i < line_.size(); ++i) {
      if (line_[i].role == Role::kEnable) set(i, false);
    }
  }
  if (now_ns < next_show_ns_) return;
  next_show_ns_ = now_ns + kLook_ns;
  ++shows_;
  bool enabled = false;
  bool alive = true;
  for (std::size_t i = 0; i < safety_.servos.size(); ++i) {
    const SafetyLines::Sign& sign = safety_.servos[i];
    const bool used = sign.used.load(std::memory_order_acquire);
    const std::uint64_t cycles = sign.cycles.load(std::memory_order_acquire);  // A9, pairs with R9 in Servo::runOnce()
    const bool advanced = cycles != std::exchange(seen_cycles_[i], cycles);
    if (!used || cycles == 0) continue;  // One that is just starting takes no other's amplifier off.
    alive = alive && advanced;
    enabled = enabled || (advanced && sign.enabled.load(std::memory_order_relaxed));
  }
  for (std::size_t i = 0; i < line_.size(); ++i) {
    switch (line_[i].role) {
      case Role::kEnable:
        set(i, enabled && alive && !barred);
        break;
      case Role::kHeartbeat:
        if (alive) set(i, !line_[i].shown);
        break;
      case Role::kLed:
        set(i, barred ? shows_ / kBlinkShows % 2 == 0 : enabled);
        break;
      default:
        break;
    }
  }
}

void Panel::set(std::size_t line, bool active) noexcept {
  if (lost() || line_[line].shown == active) return;  // One that refused has put all off, in the midst of show().
  line_[line].shown = active;
  if (!lines_->set(line, active)) lose();
}

}  // namespace hapticd
