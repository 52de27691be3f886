#include "rt/collide/collider.h"

#include <algorithm>
#include <cstring>

#include "rt/collide/scene_contacts.h"

namespace hapticd {

Collider::Collider(const VolumeTable* volumes) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    contacts_[i] =
        std::make_unique<SceneContacts>(i < kMaxDevices ? SceneContacts::kPatches : SceneContacts::kBodyPatches);
    contacts_[i]->setVolumes(volumes);
  }
}

Collider::~Collider() = default;

void Collider::step(Clock* clock) HD_RT {
  // R5, pairs with A5 in DeviceGroup::taken(): an older question than the newest is taken only after this is said, and
  // whoever sees orders passed that the newer one follows also sees it (through the exchange in Newest).
  reading_.store(kTaking, std::memory_order_release);
  if (!questions.take(question_)) {
    reading_.store(kIdle, std::memory_order_release);
    return;
  }
  reading_.store(question_.orders, std::memory_order_release);
  const auto tools = std::count_if(question_.held.begin(), question_.held.end(),
                                   [](const CollideRequest::Held& held) { return held.object != 0; });
  const std::int64_t begin_ns = clock != nullptr && tools > 0 ? clock->now() : 0;
  const std::int64_t share_ns = kBudgetNs / std::max<std::int64_t>(1, tools);
  for (std::uint32_t d = 0; d < contacts_.size(); ++d) {
    const CollideRequest::Held& held = question_.held[d];
    if (held.object == 0) {
      contacts_[d]->forget();
      continue;
    }
    const std::int64_t deadline_ns = clock != nullptr ? clock->now() + share_ns : 0;
    ContactModel& model = answer_[d];
    DetectorReport report;
    // [s] An answer is in force until the next: one period, plus half a period until it has arrived.
    const double ahead = 1.5e-9 * static_cast<double>(kPeriodNs);
    contacts_[d]->find(held, ahead, {kUnits, deadline_ns, clock}, model, report);
    Command answer;
    answer.kind = CommandKind::kToolContacts;
    auto& out = answer.as<ToolContacts>();
    out.device = d;
    out.object = held.object;
    out.count = model.count;
    out.dropped = report.dropped;
    out.tick = question_.tick;
    static_assert(ToolContacts::kMost == kMaxTouches && sizeof(ToolContacts::Point) == sizeof(ContactModel::Point));
    std::memcpy(out.point, model.point.data(), model.count * sizeof(ContactModel::Point));
    if (!answers.push(answer)) counters.unsent.fetch_add(1, std::memory_order_relaxed);
    counters.queries.fetch_add(1, std::memory_order_relaxed);
    if (report.exhausted) counters.exhausted.fetch_add(1, std::memory_order_relaxed);
    counters.last_work.store(report.work, std::memory_order_relaxed);
    counters.contacts[d].store(model.count, std::memory_order_relaxed);
  }
  if (begin_ns != 0) counters.duration.record(clock->now() - begin_ns);
  reading_.store(kIdle, std::memory_order_release);
}

}  // namespace hapticd
