// Handles of what is no more: of objects whose name was taken by another since, and of what a lost daemon began.
#include <gtest/gtest.h>

#include <hapticclient/hapticclient.hpp>
#include <utility>

#include "tests/integration/client/maker.h"

namespace hapticd::test {
namespace {

class Handles : public Maker {
 protected:
  [[nodiscard]] haptic::Result<haptic::Object> makeBall() {
    haptic_object ball = HAPTIC_OBJECT_INIT;
    ball.name = "ball";
    ball.shape = {HAPTIC_SHAPE_SPHERE, 0, {0.01, 0, 0}, 0};
    return client_->scene().create(ball);
  }
  [[nodiscard]] bool ballStands() { return client_->scene().find("ball").ok(); }
};

TEST_F(Handles, RemovesNothingOfARestartedDaemon) {
  auto ball = makeBall();
  ASSERT_TRUE(ball) << ball.error().message();
  daemon_.kill();
  ASSERT_TRUE(daemon_.start()) << daemon_.log();
  ASSERT_TRUE(client_->reconnect());
  {
    auto made = makeBall();
    ASSERT_TRUE(made) << made.error().message();
    ASSERT_EQ(made->id(), ball->id()) << "each daemon counts anew, so that the number alone says nothing";
    *ball = std::move(*made);  // What was held goes with `made`.
  }
  EXPECT_TRUE(ballStands());
  EXPECT_TRUE(ball->setFlags(HAPTIC_OBJECT_ENABLED));
  { const haptic::Object last = std::move(*ball); }
  EXPECT_FALSE(ballStands()) << "its own it removes";
}

TEST_F(Handles, OfARecordingOfALostDaemonSaysThatAnotherMustBeStarted) {
  auto recording = client_->record();
  ASSERT_TRUE(recording) << recording.error().message();
  daemon_.kill();
  ASSERT_TRUE(daemon_.start()) << daemon_.log();
  ASSERT_TRUE(client_->reconnect());
  const auto end = recording->stop();
  EXPECT_EQ(end.code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(end.error().message(), "recording: was begun before the daemon was lost (start another)");
}

TEST_F(Handles, RemovesNoOtherObjectOfItsName) {
  auto ball = makeBall();
  ASSERT_TRUE(ball) << ball.error().message();
  ASSERT_TRUE(client_->scene().remove("ball"));
  auto second = makeBall();
  ASSERT_TRUE(second) << second.error().message();
  { const haptic::Object first = std::move(*ball); }
  EXPECT_TRUE(ballStands());
}

}  // namespace
}  // namespace hapticd::test
