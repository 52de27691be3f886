// Several clients, several sessions, one device, and whatever can happen in any order: against a model that knows
// nothing of how the daemon does it.
#include <fstream>
#include <optional>
#include <sstream>

#include "tests/session/bench.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kOffAtOnce_ms = 10;   ///< After a stop or a fault; the servo takes orders in five cycles.
constexpr std::int64_t kLowered_ms = 20;     ///< After all else: what the slew limit makes of the most force, besides.
constexpr std::int64_t kFaded_ms = 280;      ///< From the last heartbeat: 200 to be missed, 50 to fade, and the slew.
constexpr std::int64_t kAnswered_ms = 1100;  ///< An order to arm.
constexpr std::size_t kMostSessions = 4;

/** A program with one session. */
struct Player {
  std::uint64_t connection = 0, session = 0;
  std::unique_ptr<ClientSide> side;
  bool beats = true;
  std::int64_t beat_ms = 0;  ///< Its last heartbeat.
};

/** An order to arm that was given. */
struct Arming {
  std::uint64_t session = 0;
  std::int64_t since_ms = 0;
  bool taken = false;  ///< Not refused at once.
  int answers = 0;
  std::optional<ErrorCode> code;
};

/** The world, and what may be true of the device in it. */
class World {
 public:
  explicit World(std::uint32_t seed) : random_(seed) {
    auto list = ArmedList::open(path_);
    EXPECT_TRUE(list.ok());
    bench_.core.keepArmed(std::move(*list));
  }

  void act() {
    switch (random_.below(16)) {
      case 0:
      case 1:
        return open();
      case 2:
        return leave();
      case 3:
      case 4:
      case 5:
        return arm();
      case 6:
        if (Player* const one = any(); one != nullptr && bench_.core.disarm(one->session)) calledOff(false);
        return;
      case 7:
        if (Player* const one = any(); one != nullptr && bench_.core.releaseLease(one->session)) calledOff(false);
        return;
      case 8:
        if (Player* const one = any()) (void)bench_.core.acquireLease(one->session);
        return;
      case 9:
        if (!random_.once(3)) return;
        EXPECT_TRUE(bench_.core.stop("", bench_.administration).ok());
        return calledOff(true);
      case 10:
        if (Player* const one = any()) one->beats = !one->beats;
        return;
      case 11:
        return device();
      case 12:
        for (int n = random_.below(200); n > 0; --n) bench_.device().applyRadius();  // What others wait behind.
        return;
      case 13:
        if (asleep_ || random_.once(4)) {
          asleep_ = !asleep_;
          bench_.core.setAsleep(asleep_);
          if (asleep_) calledOff(true);
        }
        return;
      default:
        if (Player* const one = any()) (void)one->side->push(random_.vector(3));
        return;
    }
  }

  void step() {
    ++now_ms_;
    for (const auto& link : bench_.core.devices().links()) link->group().step();
    for (const auto& one : players_) {
      if (!one->beats) continue;
      one->side->producer->heartbeat(bench_.clock.now());
      one->beat_ms = now_ms_;
    }
    bench_.core.poll();
    check();
  }

  [[nodiscard]] int timesOn() const { return times_on_; }

 private:
  Player* any() { return players_.empty() ? nullptr : players_[random_.below(players_.size())].get(); }

  void open() {
    if (players_.size() == kMostSessions) return;
    auto one = std::make_unique<Player>();
    one->connection = *bench_.core.connect(100, 1000 + random_.below(2u), false);
    const auto session = bench_.core.openSession("", one->connection, "player", HD_SHM_MAJOR, HD_SHM_MINOR);
    if (!session) return bench_.core.disconnect(one->connection);  // Those that ended fade still.
    one->session = (*session)->id;
    one->side = std::make_unique<ClientSide>(**session);
    one->beat_ms = now_ms_;
    EXPECT_TRUE(bench_.core.sessions().mapped(one->session).ok());
    players_.push_back(std::move(one));
  }

  void leave() {
    if (players_.empty()) return;
    const std::size_t i = random_.below(players_.size());
    if (bench_.device().lease == players_[i]->session) calledOff(false);
    if (random_.once(2)) bench_.core.sessions().end(players_[i]->session, "test");
    bench_.core.disconnect(players_[i]->connection);
    left_ms_ = now_ms_;
    players_.erase(players_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  void arm() {
    Player* const one = any();
    if (one == nullptr) return;
    const bool may = bench_.device().lease == 0 || bench_.device().lease == one->session;
    auto& arming = *armings_.emplace_back(std::make_unique<Arming>());
    arming.session = one->session;
    arming.since_ms = now_ms_;
    bench_.core.arm(one->session, [this, &arming](const Result<void>& result) {
      ++arming.answers;
      arming.code = result ? ErrorCode::kOk : result.error().code;
      if (!result && arming.taken && &arming == armings_.back().get()) calledOff(false);
      if (!result) return;
      EXPECT_EQ(bench_.device().lease, arming.session) << "who is told that it is armed holds the lease";
      EXPECT_NE(bench_.sample().flags & HD_SAMPLE_ARMED, 0u) << "and it is";
    });
    arming.taken = !arming.code.has_value();
    EXPECT_FALSE(arming.taken && (!may || asleep_));
    wanted_ = wanted_ || arming.taken;
  }

  void device() {
    DeviceSample& sample = bench_.scripted[0]->sample;
    switch (random_.below(4)) {
      case 0:
        sample.status = kDeviceError;
        break;
      case 1:
        sample.status = kDeviceDeadmanOpen;
        break;
      default:
        sample.status = kDeviceOk;
    }
    if (sample.status != kDeviceOk) broken_ms_ = now_ms_;
  }

  /** From now on nobody wants it on. */
  void calledOff(bool at_once) {
    wanted_ = false;
    off_ms_ = now_ms_;
    if (at_once) at_once_ms_ = now_ms_;
  }

  void check() {
    const DeviceCommand& sent = bench_.scripted[0]->sent.back();
    if (sent.enabled && !was_on_) ++times_on_;
    const auto waits = [](const auto& arming) { return arming->answers == 0; };
    const bool broken = bench_.scripted[0]->sample.status != kDeviceOk;
    if (broken && was_on_ && std::none_of(armings_.begin(), armings_.end(), waits)) calledOff(true);  // It latches.
    was_on_ = sent.enabled;
    EXPECT_LE(sent.force.norm(), bench_.device().limits.force) << now_ms_;
    if (!sent.enabled) {
      EXPECT_EQ(sent.force.norm(), 0) << now_ms_;
    }
    if (broken && now_ms_ - broken_ms_ >= kOffAtOnce_ms) {
      EXPECT_FALSE(sent.enabled) << "a fault stands, at " << now_ms_;
    }
    const std::int64_t patience_ms = at_once_ms_ == off_ms_ ? kOffAtOnce_ms : kLowered_ms;
    if (!wanted_ && now_ms_ - off_ms_ >= patience_ms) {
      EXPECT_FALSE(sent.enabled) << "called off at " << off_ms_ << ", and now it is " << now_ms_;
    }
    const auto beats = [this](const auto& one) { return now_ms_ - one->beat_ms < kFaded_ms; };
    const bool some = now_ms_ - left_ms_ < kFaded_ms || std::any_of(players_.begin(), players_.end(), beats);
    if (!some) {
      EXPECT_EQ(sent.force.norm(), 0) << "nobody is heard of, at " << now_ms_;
    }
    const std::uint64_t lease = bench_.device().lease;
    EXPECT_TRUE(lease == 0 || bench_.core.sessions().find(lease) != nullptr) << "a dead man's lease";
    for (const auto& arming : armings_) {
      EXPECT_LE(arming->answers, 1);
      if (now_ms_ - arming->since_ms < kAnswered_ms) continue;
      EXPECT_EQ(arming->answers, 1) << "of the order of " << arming->since_ms;
    }
    std::erase_if(armings_, [this](const auto& one) { return one->answers == 1 && one->since_ms + 2000 < now_ms_; });
    if (sent.enabled && now_ms_ % 16 == 0) {
      std::stringstream listed;
      listed << std::ifstream(path_).rdbuf();
      EXPECT_NE(listed.str().find("test://first"), std::string::npos) << "on, and not on the list";
    }
  }

  Random random_;
  TemporaryDirectory folder_;
  std::string path_ = folder_.path() + "/armed";
  Bench bench_;
  std::vector<std::unique_ptr<Player>> players_;
  std::vector<std::unique_ptr<Arming>> armings_;
  std::int64_t now_ms_ = 0;
  bool wanted_ = false, asleep_ = false, was_on_ = false;
  std::int64_t off_ms_ = 0, at_once_ms_ = -1000, broken_ms_ = 0, left_ms_ = 0;
  int times_on_ = 0;
};

TEST(AnyOrder, TheDeviceIsOnlyOnWhileSomebodyWantsIt) {
  int times_on = 0;
  const std::vector<unsigned> all = seeds(20);
  for (const unsigned seed : all) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world(seed);
    Random pause(seed + 1000);
    for (int i = 0; i < 400 && !testing::Test::HasFailure(); ++i) {
      world.act();
      for (int periods = pause.once(8) ? pause.below(400) : pause.below(6); periods > 0; --periods) world.step();
    }
    times_on += world.timesOn();
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(times_on, 5 * static_cast<int>(all.size())) << "else nothing was tried";
}

}  // namespace
}  // namespace hapticd::test
