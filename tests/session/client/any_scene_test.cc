// Several clients, users and servos, one scene, and whatever can happen to it in any order: against a model that knows
// nothing of how the daemon does it.
#include <algorithm>
#include <map>
#include <set>

#include "tests/session/bench.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr int kSettled = 60;  ///< Periods, in which every servo has taken every order and has told what it holds.
constexpr std::uint32_t kMostOwned = 12;
constexpr std::uint32_t kStranger = 3000;  ///< A user who owns nothing.
constexpr double kSpeed = 2e-3;            ///< Of what moves by itself, at most along each axis [m/s],
constexpr double kNear = 2e-3;             ///< so that all servos agree so well about where it is [m],
constexpr double kNearTurned = 1e-6;       ///< and how it is turned [rad].

/** An object as it must be. */
struct Thing {
  std::string parent;
  std::uint64_t connection = 0;  ///< Its maker's; 0: nobody's who is there.
  std::uint32_t uid = 0;
  bool keep = false;
  std::uint32_t id = 0;
  Pose X;
  Vec3 v = Vec3::Zero();
  std::uint64_t mover = 0;    ///< Whose ring has said so, if one did: with that connection the motion ends.
  std::int64_t since_ns = 0;  ///< It is there since then, and moves on so.
  ShapeKind kind = ShapeKind::kGroup;
  double size = 0, stiffness = 0;
  ObjectFlags flags;
};

/** A program; with a session on one of the devices, or with none. */
struct Sharer {
  std::uint64_t connection = 0;
  std::uint32_t uid = 0;
  std::uint64_t session = 0;
  std::unique_ptr<ClientSide> side;
};

Config ofFew() {
  Config config = Bench::relaxed();
  config.quotas.objects = kMostOwned;
  return config;
}

std::uint32_t bits(const ObjectFlags& flags) {
  ObjectSpec spec;
  spec.flags = flags;
  return objectFlags(spec);
}

class SharedWorld {
 public:
  explicit SharedWorld(std::uint32_t seed) : random_(seed) {}

  void act() {
    switch (random_.below(18)) {
      case 0:
        return come();
      case 1:
        return leave();
      case 2:
      case 3:
      case 4:
      case 5:
        return create();
      case 6:
        return remove();
      case 7:
      case 8:
        return edit([&](const std::string& name, Thing& thing) {
          if (random_.once(3)) {
            put(thing, placeOf(thing), random_.vector(kSpeed));
            return scene().setVelocity(name, {thing.v, Vec3::Zero()});
          }
          put(thing, random_.pose(0.1));
          return scene().setPose(name, thing.X);
        });
      case 9:
        return edit([&](const std::string& name, Thing& thing) {
          thing.stiffness = random_.in(1, 1000);
          return scene().setMaterial(name, {thing.stiffness, 0.5, 0, 0});
        });
      case 10:
        return edit([&](const std::string& name, Thing& thing) {
          thing.flags = flags();
          return scene().setFlags(name, thing.flags);
        });
      case 11:
        return edit([&](const std::string& name, Thing& thing) {
          shape(thing);
          return bench_.core.setShape(name, {thing.kind, Vec3::Constant(thing.size), 0});
        });
      case 12:
        return servos();
      case 13:
        return record();
      default:
        return push();
    }
  }

  void step(int periods) {
    for (; periods > 0; --periods) {
      for (const auto& link : bench_.core.devices().links()) {
        link->group().step();
        seeNothingRefused(*link);
      }
      for (const auto& one : players_) {
        if (one->side) one->side->producer->heartbeat(bench_.clock.now());
      }
      bench_.core.poll();
    }
  }

  /** The daemon tells, and every servo holds, what must be. */
  void check() {
    step(kSettled);
    ASSERT_EQ(scene().size(), things_.size());
    for (const auto& [name, thing] : things_) {
      const auto now = scene().find(name);
      ASSERT_TRUE(now.ok()) << name;
      EXPECT_EQ(now->id, thing.id) << name;
      EXPECT_EQ(now->spec.parent, thing.parent) << name;
      EXPECT_EQ(now->spec.keep, thing.keep) << name;
      EXPECT_EQ(now->owner, thing.connection == 0 ? "" : nameOf(thing.connection)) << name;
      expectThere(now->spec.X_PO, now->V_PO, thing, name);
      EXPECT_EQ(now->spec.shape.kind, thing.kind) << name;
      EXPECT_EQ(now->spec.material.stiffness, thing.stiffness) << name;
      EXPECT_EQ(bits(now->spec.flags), bits(thing.flags)) << name;
    }
    for (const auto& link : bench_.core.devices().links()) {
      const Scene& held = link->group().servo().cycle().scene();
      ASSERT_EQ(held.used().size(), things_.size()) << link->name();
      for (const auto& [name, thing] : things_) {
        const SceneObject* const object = held.find(thing.id);
        ASSERT_NE(object, nullptr) << name << " in " << link->name();
        EXPECT_EQ(held.slot(object->parent).id, thing.parent.empty() ? 0 : things_.at(thing.parent).id) << name;
        expectThere(object->X_PO, object->V_PO, thing, name + " in " + link->name());
        EXPECT_EQ(object->shape.kind, thing.kind) << name << " in " << link->name();
        EXPECT_EQ(object->material.stiffness, thing.stiffness) << name << " in " << link->name();
        EXPECT_EQ(object->flags, bits(thing.flags)) << name << " in " << link->name();
      }
    }
  }

  [[nodiscard]] int pushes() const { return pushes_; }
  [[nodiscard]] int servosStarted() const { return servos_started_; }
  [[nodiscard]] int recordings() const { return recordings_; }
  [[nodiscard]] int inherited() const { return inherited_; }
  [[nodiscard]] int stopped() const { return stopped_; }

 private:
  SceneModel& scene() { return bench_.core.scene(); }
  Sharer* any() { return players_.empty() ? nullptr : players_[random_.below(players_.size())].get(); }
  std::string anyName() { return std::string(1, static_cast<char>('a' + random_.below(14))); }
  static std::string nameOf(std::uint64_t connection) { return "player" + std::to_string(connection); }
  ObjectFlags flags() { return {!random_.once(3), !random_.once(3), random_.once(2)}; }
  void shape(Thing& thing) {
    constexpr ShapeKind kKinds[] = {ShapeKind::kGroup, ShapeKind::kPlane, ShapeKind::kSphere, ShapeKind::kBox};
    thing.kind = kKinds[random_.below(4)];
    thing.size = random_.in(0.001, 0.1);
  }
  void put(Thing& thing, const Pose& X, const Vec3& v = Vec3::Zero()) {
    thing.X = X;
    thing.v = v;
    thing.mover = 0;
    thing.since_ns = bench_.clock.now();
  }
  Pose placeOf(const Thing& thing) {
    return {thing.X.p + thing.v * (static_cast<double>(bench_.clock.now() - thing.since_ns) * 1e-9), thing.X.q};
  }
  void expectThere(const Pose& X, const Twist& V, const Thing& thing, const std::string& where) {
    const Pose expected = placeOf(thing);
    EXPECT_LT((X.p - expected.p).norm(), kNear) << where;
    EXPECT_LT(X.q.angularDistance(expected.q), kNearTurned) << where;
    EXPECT_EQ(V.v, thing.v) << where;
  }
  /** Here the servo is no thread: both ends of its events are ours. */
  static void seeNothingRefused(GroupLink& link) {
    auto& events = link.group().servo().events;
    ServoEvent event;
    for (std::uint32_t left = events.size(); left > 0 && events.pop(event); --left) {
      EXPECT_NE(event.kind, ServoEventKind::kCommandRefused) << link.name() << ": order " << event.order;
      (void)events.push(event);
    }
  }
  bool isBelow(std::string name, const std::string& above) {
    for (; !name.empty(); name = things_.at(name).parent) {
      if (name == above) return true;
    }
    return false;
  }
  std::vector<std::string> below(const std::string& above) {
    std::vector<std::string> all;
    for (const auto& [name, thing] : things_) {
      if (isBelow(name, above)) all.push_back(name);
    }
    return all;
  }

  void come() {
    if (players_.size() == 5) return;
    auto one = std::make_unique<Sharer>();
    one->uid = 1000 + random_.below(2u);
    one->connection = *bench_.core.connect(100, one->uid, false);
    bench_.core.introduce(one->connection, nameOf(one->connection));
    const char* const uri = random_.once(2) ? kSecond : kFirst;
    if (isOpen(uri) && !random_.once(3)) {
      const auto session = bench_.core.openSession(uri, one->connection, "", HD_SHM_MAJOR, HD_SHM_MINOR);
      ASSERT_TRUE(session.ok()) << toString(session.error());
      one->session = (*session)->id;
      one->side = std::make_unique<ClientSide>(**session);
      ASSERT_TRUE(bench_.core.sessions().mapped(one->session).ok());
    }
    players_.push_back(std::move(one));
    step(5);
  }

  void leave() {
    if (players_.empty()) return;
    const std::size_t i = random_.below(players_.size());
    const std::uint64_t gone = players_[i]->connection;
    bench_.core.disconnect(gone);
    players_.erase(players_.begin() + static_cast<std::ptrdiff_t>(i));
    // What is another's or to be kept stays, and all that carries it.
    std::set<std::string> stays;
    for (const auto& [name, thing] : things_) {
      if (thing.connection == gone && !thing.keep) continue;
      for (std::string up = name; !up.empty(); up = things_.at(up).parent) stays.insert(up);
    }
    for (auto it = things_.begin(); it != things_.end();)
      it = stays.count(it->first) == 0 ? things_.erase(it) : std::next(it);
    for (auto& [name, thing] : things_) {
      if (thing.mover == gone) {
        stopped_ += thing.v.isZero(0) ? 0 : 1;
        put(thing, placeOf(thing));
      }
      if (thing.connection != gone) continue;
      if (thing.keep) {
        thing.connection = 0;
        continue;
      }
      inherit(name, thing, gone);
    }
  }

  /** Whose it becomes: somebody's whose object it carries. Which one's the daemon says. */
  void inherit(const std::string& name, Thing& thing, std::uint64_t gone) {
    ++inherited_;
    const auto now = scene().find(name);
    ASSERT_TRUE(now.ok()) << name << " carries what stays";
    const auto refused = scene().remove(name, Client{.uid = kStranger});
    ASSERT_FALSE(refused.ok());
    const std::string whose = refused.error().what;  // Of those who have left nothing else tells the user.
    for (const std::string& other : below(name)) {
      const Thing& carried = things_.at(other);
      if (other == name || (carried.connection == gone && !carried.keep)) continue;
      const std::uint64_t heir = carried.connection == gone ? 0 : carried.connection;
      if (now->owner != (heir == 0 ? "" : nameOf(heir)) || now->spec.keep != carried.keep) continue;
      if (!whose.ends_with("user " + std::to_string(carried.uid))) continue;
      thing.connection = heir;
      thing.keep = carried.keep;
      thing.uid = carried.uid;
      return;
    }
    ADD_FAILURE() << name << " became '" << now->owner << "'s, who has nothing on it";
  }

  void create() {
    Sharer* const by = any();
    if (by == nullptr) return;
    const std::string name = anyName();
    Thing thing;
    thing.parent = random_.once(2) ? anyName() : "";
    thing.connection = by->connection;
    thing.uid = by->uid;
    thing.keep = random_.once(6);
    put(thing, random_.pose(0.1));
    thing.stiffness = random_.in(1, 1000);
    thing.flags = flags();
    shape(thing);
    ObjectSpec spec;
    spec.name = name;
    spec.parent = thing.parent;
    spec.X_PO = thing.X;
    spec.shape = {thing.kind, Vec3::Constant(thing.size), 0};
    spec.material = {thing.stiffness, 0.5, 0, 0};
    spec.flags = thing.flags;
    spec.keep = thing.keep;
    const auto owned =
        std::count_if(things_.begin(), things_.end(), [&](const auto& t) { return t.second.uid == by->uid; });
    ErrorCode expected = ErrorCode::kOk;
    if (things_.count(name) != 0) {
      expected = ErrorCode::kAlreadyExists;
    } else if (!thing.parent.empty() && things_.count(thing.parent) == 0) {
      expected = ErrorCode::kNotFound;
    } else if (owned >= kMostOwned) {
      expected = ErrorCode::kQuotaExceeded;
    }
    const auto id = scene().create(spec, bench_.core.client(by->connection));
    ASSERT_EQ(id ? ErrorCode::kOk : id.error().code, expected) << name;
    if (!id) return;
    thing.id = *id;
    things_.emplace(name, thing);
  }

  void remove() {
    Sharer* const by = any();
    if (by == nullptr) return;
    const std::string name = anyName();
    ErrorCode expected = things_.count(name) == 0 ? ErrorCode::kNotFound : ErrorCode::kOk;
    const auto with_it = below(name);
    for (const std::string& each : with_it) {
      if (things_.at(each).uid != by->uid) expected = ErrorCode::kPermissionDenied;
    }
    const auto removed = scene().remove(name, bench_.core.client(by->connection));
    ASSERT_EQ(removed ? ErrorCode::kOk : removed.error().code, expected) << name;
    if (!removed) return;
    for (const std::string& each : with_it) things_.erase(each);
  }

  /** One that is accepted for what is there, and else refused. */
  template <class Edit>
  void edit(const Edit& edit) {
    const std::string name = anyName();
    const auto it = things_.find(name);
    Thing nothing;
    const Result<void> done = edit(name, it == things_.end() ? nothing : it->second);
    ASSERT_EQ(done ? ErrorCode::kOk : done.error().code, it == things_.end() ? ErrorCode::kNotFound : ErrorCode::kOk);
  }

  /** By the rings of clients, of one servo or of two. Whether it or an edit that is on its way came last nobody could
   * tell: none is. */
  void push() {
    if (things_.empty()) return;
    step(kSettled);
    auto it = things_.begin();
    std::advance(it, random_.below(static_cast<int>(things_.size())));
    const int what = random_.below(3);
    push(it->second, what);
    if (random_.once(2)) push(it->second, (what + 1) % 3);
    step(3);  // Ingest and servo have it; what else comes, comes later.
    if (random_.once(2)) step(kSettled);
  }

  void push(Thing& thing, int what) {
    Sharer* const by = any();
    if (by == nullptr || by->side == nullptr) return;
    std::uint64_t seq = 0;
    const auto give = [&](std::uint32_t kind, const auto& message) {
      ASSERT_EQ(by->side->producer->push(kind, std::as_bytes(std::span(&message, 1)), 0, seq), ErrorCode::kOk);
      ++pushes_;
    };
    switch (what) {
      case 0:
        put(thing, random_.pose(0.1), random_.once(2) ? random_.vector(kSpeed) : Vec3::Zero());
        thing.mover = by->connection;
        return give(HD_COMMAND_OBJECT_POSE, poseMessage(thing.id, thing.X, {thing.v, Vec3::Zero()}));
      case 1:
        thing.stiffness = random_.in(1, 1000);
        return give(HD_COMMAND_OBJECT_MATERIAL, hd_object_material{thing.id, 0, {thing.stiffness, 0.5, 0, 0}});
      default:
        thing.flags = flags();
        return give(HD_COMMAND_OBJECT_FLAGS, hd_object_flags{thing.id, 7, bits(thing.flags), 0});
    }
  }

  bool isOpen(const char* uri) { return bench_.core.devices().find(uri).ok(); }

  /** A second servo comes or goes. */
  void servos() {
    if (isOpen(kSecond)) {
      (void)bench_.core.closeDevice(kSecond, bench_.administration);  // Not while a session uses it.
      return;
    }
    const auto opened = bench_.core.openDevice(kSecond, bench_.administration);
    if (!opened && opened.error().code == ErrorCode::kDeviceBusy) return;  // A busy machine holds up its closing.
    ASSERT_TRUE(opened.ok()) << toString(opened.error());
    ++servos_started_;
  }

  /** The cycle is made anew. */
  void record() {
    if (!random_.once(4)) return;  // It takes as long as a hundred of the others.
    // Drawn before: whether the last one has ended yet is a matter of real time.
    const char* const uri = random_.once(2) && isOpen(kSecond) ? kSecond : kFirst;
    const int periods = random_.below(3);
    const auto started = bench_.core.record(uri, bench_.administration);
    if (!started) {
      ASSERT_EQ(started.error().code, ErrorCode::kAlreadyExists) << toString(started.error());
      return;
    }
    ++recordings_;
    step(periods);
    bench_.core.recordings().drop(started->id);
  }

  static constexpr const char* kFirst = "test://first";
  static constexpr const char* kSecond = "test://second";
  Random random_;
  Bench bench_{ofFew()};
  std::vector<std::unique_ptr<Sharer>> players_;
  std::map<std::string, Thing> things_;
  int pushes_ = 0, servos_started_ = 0, recordings_ = 0, inherited_ = 0, stopped_ = 0;
};

TEST(AnyScene, IsWithEveryServoAsItWasSaidToBe) {
  int pushes = 0, servos = 0, recordings = 0, inherited = 0, stopped = 0;
  for (const unsigned seed : seeds(16)) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SharedWorld world(seed);
    Random pause(seed + 1000);
    for (int i = 0; i < 300 && !testing::Test::HasFailure(); ++i) {
      world.act();
      if (pause.once(2)) world.step(pause.below(4));
      if (pause.once(10)) world.check();
    }
    pushes += world.pushes();
    servos += world.servosStarted();
    recordings += world.recordings();
    inherited += world.inherited();
    stopped += world.stopped();
    if (testing::Test::HasFailure()) return;
  }
  if (drawsAll()) {
    EXPECT_GT(pushes, 100) << "else nothing was tried";
    EXPECT_GT(servos, 20);
    EXPECT_GT(recordings, 10);
    EXPECT_GT(inherited, 4);
    EXPECT_GT(stopped, 5);
  }
}

}  // namespace
}  // namespace hapticd::test
