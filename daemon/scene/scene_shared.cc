// What clients change through the rings of one servo is handed on to all others.
#include <algorithm>

#include "daemon/scene/scene_model.h"

namespace hapticd {
namespace {

constexpr double kStrayed = 1e-4, kStrayedTurn = 5e-3;  ///< So far apart may two servos have a body [m, rad].
constexpr int kMostPutBack = 20;

}  // namespace

void SceneModel::followClients() {
  const auto servos = std::count_if(sinks_.begin(), sinks_.end(), [](const CommandSink* s) { return s != nullptr; });
  if (servos < 2) return;
  for (const auto& [name, slot] : by_name_) follow(slots_[slot]);
}

/**
 * Changes are counted, not seen by what differs: a place moves on by itself. Those that crossed an order of ours come
 * last, and nowhere where that servo is behind: what it shows may be that order, which others have changed since.
 */
void SceneModel::follow(Object& object) {
  for (const Part part : kAllParts) {
    for (const bool crossed : {false, true}) {
      for (std::size_t i = 0; i < sinks_.size(); ++i) {
        Known& known = object.known[i][part];
        PosedObject now;
        if (known.crossed != crossed || !posed(object, i, part, now)) continue;
        known.crossed = false;
        if (now.client_edits[part] == known.client_edits) continue;
        known.client_edits = now.client_edits[part];
        if (crossed && known.behind) continue;
        takeOver(now, i, part, object);
        if (part == SceneObject::kPlace) {
          object.teller = sinks_[i];
          object.settles = false;
        }
        for (std::size_t k = 0; k < sinks_.size(); ++k) object.known[k][part].behind = k != i;
      }
    }
    if (part == SceneObject::kPlace && object.spec.body.mass > 0) followBody(object);
    if (part == SceneObject::kPlace && object.settles) settle(object);
    // One order at a time: a servo slower than that whose clients move things would never come to the end of them.
    for (std::size_t i = 0; i < sinks_.size(); ++i) {
      const Known& known = object.known[i][part];
      if (sinks_[i] == nullptr || !known.behind) continue;
      if (!sinks_[i]->accepting() || !sinks_[i]->passed(known.ticket)) continue;
      if (part == SceneObject::kPlace && !object.in_hand) moveOn(object);  // Its hand tells anew in each tick.
      postPart(object, part, i);
    }
  }
}

/** What it does by itself is no edit. */
void SceneModel::followBody(Object& object) {
  const std::size_t i = tellerOf(object);
  PosedObject now;
  if (i == sinks_.size() || object.known[i][SceneObject::kPlace].behind) return;
  if (!posed(object, i, SceneObject::kPlace, now)) return;
  std::array<double, 13> here;
  auto to = here.begin();
  const auto add = [&](const auto& part) { to = std::copy(std::begin(part), std::end(part), to); };
  add(now.p_PO);
  add(now.q_PO);
  add(now.v_PO);
  add(now.w_PO);
  if (here != object.told) {
    object.told = here;
    object.put_back = 0;
    takeOver(now, i, SceneObject::kPlace, object);
    for (std::size_t k = 0; k < sinks_.size(); ++k) object.known[k][SceneObject::kPlace].behind = k != i;
    return;
  }
  // What moves is told with the next place: this one may be of some ticks ago. And where the servos' worlds differ, as
  // by a client's dent, it would be put back for ever.
  const bool rests = std::all_of(here.begin() + 7, here.end(), [](double v) { return v == 0; });
  if (!rests || object.put_back == kMostPutBack) return;
  const Pose X{vec3(now.p_PO), quat(now.q_PO)};
  bool any = false;
  for (std::size_t k = 0; k < sinks_.size(); ++k) {
    PosedObject other;
    if (k == i || !posed(object, k, SceneObject::kPlace, other)) continue;
    const bool strayed =
        (vec3(other.p_PO) - X.p).norm() > kStrayed || quat(other.q_PO).angularDistance(X.q) > kStrayedTurn;
    if (!strayed) continue;
    object.known[k][SceneObject::kPlace].behind = any = true;  // What it met there, nobody met here.
  }
  if (!any) return;
  ++object.put_back;
  takeOver(now, i, SceneObject::kPlace, object);
}

void SceneModel::settle(Object& object) {
  const std::size_t i = tellerOf(object);
  PosedObject now;
  if (i == sinks_.size() || !posed(object, i, SceneObject::kPlace, now)) return;
  object.settles = false;
  takeOver(now, i, SceneObject::kPlace, object);
  for (std::size_t k = 0; k < sinks_.size(); ++k) object.known[k][SceneObject::kPlace].behind = k != i;
}

std::size_t SceneModel::tellerOf(const Object& object) const {
  const auto known = std::find(sinks_.begin(), sinks_.end(), object.teller);
  const auto first = [](const CommandSink* s) { return s != nullptr; };
  const auto it =
      object.teller != nullptr && known != sinks_.end() ? known : std::find_if(sinks_.begin(), sinks_.end(), first);
  return static_cast<std::size_t>(it - sinks_.begin());
}

void SceneModel::refresh() {
  for (const auto& [name, slot] : by_name_) refresh(slots_[slot]);
}

void SceneModel::refresh(Object& object, const CommandSink* first) {
  follow(object);
  const auto known = std::find(sinks_.begin(), sinks_.end(), first);
  for (const Part part : kAllParts) {
    PosedObject now;
    const auto tells = [&](std::size_t i) { return !object.known[i][part].behind && posed(object, i, part, now); };
    const bool by_itself = part == SceneObject::kPlace && (object.spec.body.mass > 0 || object.settles);
    std::size_t i = by_itself ? tellerOf(object) : 0;
    if (first != nullptr && known != sinks_.end()) i = static_cast<std::size_t>(known - sinks_.begin());
    if (i > 0 && !(i < sinks_.size() && tells(i))) i = 0;
    while (i < sinks_.size() && !tells(i)) ++i;
    if (i < sinks_.size()) takeOver(now, i, part, object);
  }
}

void SceneModel::madeAnew(const CommandSink& sink) {
  const auto i = std::find(sinks_.begin(), sinks_.end(), &sink) - sinks_.begin();
  if (static_cast<std::size_t>(i) == sinks_.size()) return;
  for (Object& object : slots_) {
    for (Known& known : object.known[static_cast<std::size_t>(i)]) known = {.ticket = known.ticket};
  }
}

void SceneModel::postPart(Object& object, Part part) {
  if (part == SceneObject::kPlace) object.settles = false;
  for (std::size_t i = 0; i < sinks_.size(); ++i) {
    if (sinks_[i] != nullptr) postPart(object, part, i);
  }
}

void SceneModel::postPart(Object& object, Part part, std::size_t sink) {
  const Command command = part == SceneObject::kPlace      ? poseCommand(object)
                          : part == SceneObject::kMaterial ? materialCommand(object)
                                                           : flagsCommand(object);
  Known& known = object.known[sink][part];
  known.ticket = sinks_[sink]->post(command);
  known.behind = false;
  known.crossed = true;
}

bool SceneModel::posed(const Object& object, std::size_t sink, Part part, PosedObject& out) const {
  return sinks_[sink] != nullptr && sinks_[sink]->posed(objectSlot(object.id), object.known[sink][part].ticket, out) &&
         out.object == object.id;
}

void SceneModel::takeOver(const PosedObject& now, std::size_t sink, Part part, Object& object) {
  if (part == SceneObject::kPlace) {
    object.spec.X_PO = {vec3(now.p_PO), quat(now.q_PO)};
    object.V_PO = {vec3(now.v_PO), vec3(now.w_PO)};
    object.placed_in = sinks_[sink];
    object.placed_at = now.tick;
  } else if (part == SceneObject::kMaterial) {
    object.spec.material = now.material;
  } else {
    object.spec.flags = {.enabled = (now.flags & HD_OBJECT_ENABLED) != 0,
                         .visible = (now.flags & HD_OBJECT_VISIBLE) != 0,
                         .two_sided = (now.flags & HD_OBJECT_TWO_SIDED) != 0};
  }
}

void SceneModel::stand(std::uint32_t id, const Twist& V_PO) {
  Object& object = slots_[objectSlot(id)];
  if (id == 0 || object.id != id || object.spec.body.mass > 0) return;
  if (object.V_PO.v != V_PO.v || object.V_PO.w != V_PO.w) return;  // Another's by now.
  object.V_PO = {};
  postPart(object, SceneObject::kPlace);
}

void SceneModel::moveOn(Object& object) {
  if (object.spec.body.mass > 0) return;  // What it has met since stopped it: straight on is inside of that.
  if (object.placed_in == nullptr) {
    const auto any = std::find_if(sinks_.begin(), sinks_.end(), [](const CommandSink* s) { return s != nullptr; });
    if (any == sinks_.end()) return;
    object.placed_in = *any;
    object.placed_at = object.placed_in->nextTick();
  }
  const std::uint64_t next = std::max(object.placed_at, object.placed_in->nextTick());
  const double time =
      static_cast<double>(next - object.placed_at) * static_cast<double>(object.placed_in->periodNs()) * 1e-9;
  object.spec.X_PO.p += time * object.V_PO.v;
  object.spec.X_PO.q = rotated(object.spec.X_PO.q, object.V_PO.w, time);
  object.placed_at = next;
}

}  // namespace hapticd
