/** @file
 * What threads look at while the servo goes on, under every reordering: where objects are, and memory that goes.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "rt/collide/collider.h"
#include "rt/cycle/pose_board.h"
#include "tests/model/weak_memory.h"
#include "tests/support/seeds.h"
#include "tests/support/stepped/solid.h"

namespace hapticd::model {
namespace {

TEST(WeakScene, APoseIsReadWholeAndNeverOlderThanTheLast) {
  MeshTable table;
  const auto scene = std::make_unique<Scene>(table);
  const AddObject ball = test::solid(makeObjectId(1, 1), ShapeKind::kSphere, {500, 0, 0, 0}, {}, {0.01, 0, 0});
  ASSERT_EQ(scene->apply(makeCommand(CommandKind::kAddObject, ball)), ErrorCode::kOk);

  int reads = 0;
  const Found found = exploreSome(10'000, seedOf(1), [&](Threads& threads) {
    const auto board = std::make_unique<PoseBoard>();
    threads.add([&] {
      for (std::uint64_t tick = 1; tick <= 3; ++tick) {
        const double x = static_cast<double>(tick);
        const hd_object_pose pose{ball.object, 0, {x, 0, x}, {1, 0, 0, 0}, {x, 0, 0}, {0, 0, x}};
        (void)scene->apply(makeCommand(CommandKind::kObjectPose, pose));
        board->publish(*scene, tick, static_cast<std::uint32_t>(tick));
      }
    });
    threads.add([&] {
      std::uint64_t last = 0;
      for (int turn = 0; turn < 3; ++turn) {
        PosedObject posed;
        if (!board->read(1, posed) || posed.object == 0) continue;
        ++reads;
        const double x = static_cast<double>(posed.tick);
        threads.expect(posed.p_PO[0] == x && posed.p_PO[2] == x && posed.v_PO[0] == x && posed.w_PO[2] == x &&
                           posed.control_applied == posed.tick,
                       "torn");
        threads.expect(posed.tick >= last, "older than the last");
        last = posed.tick;
      }
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_GT(reads, 0);
}

/** Looks in at what the collide thread does while it answers. */
class Looks final : public Clock {
 public:
  explicit Looks(std::function<void()> look) : look_(std::move(look)) {}
  [[nodiscard]] std::int64_t now() HD_RT override {
    look_();
    return 0;
  }
  void sleepUntil(std::int64_t /*t_ns*/) HD_RT override {}

 private:
  std::function<void()> look_;
};

// DeviceGroup::taken() tells the control thread which orders have passed: what they dropped is freed then, and neither
// the servo nor the collide thread may still look at it.
TEST(WeakScene, NothingIsFreedThatTheColliderStillReads) {
  constexpr std::uint32_t kOrders = 3;
  struct Use {
    std::uint32_t orders = 0;
    Mark last_look;
  };
  const auto collider = std::make_unique<Collider>();
  const auto question = std::make_unique<CollideRequest>();
  std::uint32_t most_taken = 0;
  bool waited = false;
  const Found found = exploreSome(20'000, seedOf(1), [&](Threads& threads) {
    collider->step(nullptr);  // What an earlier run has left.
    for (Command answer; collider->answers.pop(answer);) {
    }
    std::atomic<std::uint32_t> applied{0};
    std::vector<Use> uses;
    std::uint32_t taken = 0;
    threads.add([&] {  // Servo::ask(), then Servo::count()
      for (std::uint32_t orders = 1; orders <= kOrders; ++orders) {
        question->orders = orders;
        question->held[0].object = orders;
        collider->questions.put(*question);
        applied.store(orders, std::memory_order_release);
      }
    });
    threads.add([&] {
      for (int turn = 0; turn < 3; ++turn) {
        Looks looks([&] {
          const auto orders = static_cast<std::uint32_t>(collider->reading());
          threads.expect(taken <= orders, "read after it was freed");
          if (uses.empty() || uses.back().orders != orders) uses.push_back({orders, {}});
          uses.back().last_look = threads.mark();
        });
        collider->step(&looks);
      }
    });
    threads.add([&] {
      for (int turn = 0; turn < 4; ++turn) {
        std::uint64_t passed = applied.load(std::memory_order_acquire);
        const std::uint64_t reading = collider->reading();
        if (reading == Collider::kTaking) continue;
        if (reading != Collider::kIdle) {
          waited |= reading < passed;
          passed = std::min(passed, reading);
        }
        taken = std::max(taken, static_cast<std::uint32_t>(passed));
        for (const Use& use : uses) {
          threads.expect(use.orders >= taken || threads.knowsMoreThan(use.last_look), "freed before it was read");
        }
        most_taken = std::max(most_taken, taken);
      }
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_EQ(most_taken, kOrders);
  EXPECT_TRUE(waited) << "some run must find the collider at work on an older question";
}

}  // namespace
}  // namespace hapticd::model
