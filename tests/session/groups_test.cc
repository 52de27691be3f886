// Two servos, one scene.
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

TEST(TwoGroups, ShareTheSceneAndWhatAClientMovesMovesForBoth) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  ObjectSpec spec;
  spec.name = "ball";
  spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
  spec.material = kDefaultMaterial;
  const auto id = bench.core.scene().create(spec, bench.core.client(bench.connection));
  ASSERT_TRUE(id.ok());
  auto second = bench.core.openDevice("test://second");
  ASSERT_TRUE(second.ok());
  EXPECT_EQ((*second)->name, "test2");
  ASSERT_EQ(bench.core.devices().links().size(), 2u);
  bench.step(40);
  const auto pose = [&](std::size_t group) {
    const SceneObject* object = bench.core.devices().links()[group]->group().servo().cycle().scene().find(*id);
    return object == nullptr ? -1.0 : object->X_PO.p.z();
  };
  EXPECT_EQ(pose(0), 0.0);
  EXPECT_EQ(pose(1), 0.0) << "the late servo got the scene";

  hd_object_pose moved{};
  moved.object = *id;
  moved.p[2] = 0.125;
  moved.q[0] = 1;
  std::uint64_t seq = 0;
  ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&moved, 1)), 0, seq),
            ErrorCode::kOk);
  bench.step(60);
  EXPECT_EQ(pose(0), 0.125);
  EXPECT_EQ(pose(1), 0.125);
  EXPECT_EQ(bench.core.scene().find("ball")->spec.X_PO.p.z(), 0.125);
  const auto sent = bench.core.devices().links()[1]->posted();
  bench.step(60);
  EXPECT_EQ(bench.core.devices().links()[1]->posted(), sent) << "handed on once, not for ever";

  ASSERT_TRUE(bench.core.scene().setPose("ball", {}).ok());
  bench.step(40);
  EXPECT_EQ(pose(0), 0.0);
  EXPECT_EQ(pose(1), 0.0);
}

}  // namespace
}  // namespace hapticd::test
