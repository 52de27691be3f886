#include "daemon/device/group_link.h"

#include <sys/mman.h>

#include <algorithm>

#include "rt/cycle/restated.h"
#include "rt/ring/state.h"

namespace hapticd {
namespace {

bool isOfScene(const Command& command) {
  const Restated by = whoRestates(command.kind);
  return by == Restated::kSceneAdd || by == Restated::kSceneOrder || by == Restated::kScene;
}

}  // namespace

GroupLink::GroupLink(std::string name, std::int64_t period_ns)
    : name_(std::move(name)), period_ns_(period_ns), meshes_(std::make_unique<MeshTable>()) {}

Result<std::unique_ptr<GroupLink>> GroupLink::start(std::string name, const GroupOptions& options,
                                                    std::vector<std::unique_ptr<Device>> devices, Clock& clock) {
  std::unique_ptr<GroupLink> link(new GroupLink(std::move(name), options.cycle.period_ns));
  void* memory =
      mmap(nullptr, sizeof(hd_region_a), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) return Error{ErrorCode::kSystem, link->name_, "no memory for the group's monitor", {}};
  link->monitor_ = static_cast<hd_region_a*>(memory);
  (void)mlock(memory, sizeof(hd_region_a));  // the group's own check says whether memory can be locked at all
  const auto b = std::make_unique<hd_region_b>();
  RegionIdentity identity;
  identity.device_count = static_cast<std::uint32_t>(devices.size());
  identity.period_ns = options.cycle.period_ns;
  initialiseRegions(link->monitor_, b.get(), identity);
  auto group = DeviceGroup::start(options, std::move(devices), *link->meshes_, clock);
  if (!group) return group.error();
  link->group_ = std::move(*group);
  // Release, pairs with the servo's acquire when it takes kAddSession: the region is initialised.
  link->group_->servo().ports[kClientSessions].region.store(link->monitor_, std::memory_order_release);
  (void)link->urgent(makeCommand(CommandKind::kAddSession, SessionRef{kClientSessions, 0, 0}));  // the ring is empty
  return link;
}

GroupLink::~GroupLink() {
  group_.reset();  // joins the servo, which writes the monitor
  if (monitor_ != nullptr) munmap(monitor_, sizeof(hd_region_a));
}

bool GroupLink::endThreads(std::int64_t patience_ns) {
  if (standsStill()) return false;
  if (group_->endThreads(patience_ns)) return true;
  stands_at_ = cycles() + 1;
  return false;
}

DeviceGroup::Leaving GroupLink::stop() {
  DeviceGroup::Leaving leaving = group_->takeDevices();
  group_.reset();
  return leaving;
}

std::uint64_t GroupLink::post(const Command& command) {
  const bool arms = command.kind == CommandKind::kArm;
  outbox_.push(command, arms ? arming(command.as<DeviceRef>().device) : *giver_);
  flush();
  return posted();
}

bool GroupLink::flush() {
  while (!outbox_.empty() && group_->sent() - group_->taken() < kInFlight && group_->send(outbox_.front())) {
    const Command& sent = outbox_.front();
    if (sent.kind == CommandKind::kArm) off_[sent.as<DeviceRef>().device].kind = CommandKind::kNone;
    outbox_.pop();
    ++sent_;
  }
  return !outbox_.empty();
}

void GroupLink::forgetSceneOrders() {
  for (auto& [order, whose] : outbox_) {  // Replaced, not taken out: tickets count places.
    if (isOfScene(order)) order = Command{};
  }
  // Each entry is popped and pushed back once: while the servo stands still, both ends of the ring are ours.
  ControlToServo& ring = group_->servo().from_control;
  Command command;
  for (std::uint32_t left = ring.size(); left > 0 && ring.pop(command); --left) {
    (void)ring.push(isOfScene(command) ? Command{} : command);  // There is room: one has just left.
  }
}

bool GroupLink::urgent(const Command& command) {
  if (!group_->send(command)) return false;
  ++urgent_;
  return true;
}

bool GroupLink::switchOff(std::uint32_t device, CommandKind kind, std::int64_t now_ns) {
  for (auto& [order, whose] : outbox_) {  // Replaced, not taken out: tickets count places.
    if (order.kind == CommandKind::kArm && order.as<DeviceRef>().device == device)
      order = makeCommand(CommandKind::kDisarm, DeviceRef{device});
  }
  Off& off = off_[device];
  const bool waits_already = waits(off);
  if (waits_already && (off.kind == kind || off.kind == CommandKind::kStop)) return true;  // A stop disarms, too.
  if (!urgent(makeCommand(kind, DeviceRef{device}))) return false;
  off = {group_->sent(), kind, waits_already ? off.since_ns : std::max<std::int64_t>(now_ns, 1)};
  return true;
}

bool GroupLink::waits(const Off& off) const { return off.order > group_->takenByServo(); }

std::int64_t GroupLink::offSince(std::uint32_t device) const { return waits(off_[device]) ? off_[device].since_ns : 0; }

bool GroupLink::lowerLimits(std::uint32_t device, const GuardLimits& most) {
  if (group_->sent() - group_->taken() >= kInFlight + kLowering) return false;
  if (!urgent(makeCommand(CommandKind::kDeviceLimits, limitsOrder(device, most, true)))) return false;
  for (auto& [order, whose] : outbox_) {
    if (order.kind != CommandKind::kDeviceLimits) continue;
    const auto& waits = order.as<DeviceLimits>();
    if (waits.device != device) continue;
    order = makeCommand(CommandKind::kDeviceLimits,
                        limitsOrder(device, lower(limitsOf(waits), most), waits.only_lowers != 0));
  }
  return true;
}

// A ticket's number among all orders is at most ticket + urgent_: equal once everything sent has been taken, so the
// answer is late at worst, never early.
bool GroupLink::passed(std::uint64_t ticket) { return ticket <= sent_ && group_->taken() >= ticket + urgent_; }

bool GroupLink::posed(std::uint32_t slot, std::uint64_t ticket, PosedObject& out) {
  if (ticket > sent_ || !group_->servo().poses.read(slot, out)) return false;
  return group_->widened(out.control_applied) >= ticket + urgent_;
}

std::uint64_t GroupLink::nextTick() const {
  hd_sample sample{};
  return latest(0, sample) ? sample.tick + 1 : 0;
}

bool GroupLink::latest(std::uint32_t device, hd_sample& out) const { return StateReader(monitor_).latest(device, out); }

std::uint64_t GroupLink::cycles() const {
  return group_->servo().counters.cycles.load(std::memory_order_acquire);  // A7, pairs with R7 in Servo::count()
}

}  // namespace hapticd
