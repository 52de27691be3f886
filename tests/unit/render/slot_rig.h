/** @file
 * A slot of local models in a scene, evaluated by hand, millisecond by millisecond.
 */
#pragma once

#include <gtest/gtest.h>

#include "tests/support/stepped/solid.h"
#include "tests/unit/render/model_rig.h"

namespace hapticd {

class SlotTest : public ::testing::Test {
 protected:
  MeshTable meshes;
  Scene scene{meshes};
  LocalModelSlot slot;
  ToolPoint tool{{0, 0, -0.002}, Vec3::Zero(), 0};
  std::int64_t now = 5'000 * kMs;

  Vec3 at(std::int64_t ms) { return slot.evaluate(tool, now + ms * kMs, scene).force; }
  void set(const hd_local_model& m, std::int64_t ms) {
    ASSERT_EQ(slot.set(commandOf(m, ++seq_), now + ms * kMs, scene), ErrorCode::kOk);
  }
  /** A plane, each time another that says the same. */
  hd_local_model planeAgain() {
    hd_local_model m = modelOf(HD_MODEL_PLANE);
    m.origin[0] = 1e-6 * static_cast<double>(seq_);
    return m;
  }
  /** In force from 0 to 21 ms, when it holds a hand that has gone 1 mm along it with 0.5 N. */
  hd_local_model stickingPlane() {
    hd_local_model m = modelOf(HD_MODEL_PLANE);
    m.material.friction_static = 0.8;
    m.material.friction_dynamic = 0.5;
    set(m, 0);
    (void)at(0);
    (void)at(20);
    tool.p.x() = 0.001;
    EXPECT_NEAR(at(21).x(), -0.5, 1e-12);
    return m;
  }
  /** An object at p, moving with v. Returns its id. */
  std::uint32_t addObject(const Vec3& p, const Vec3& v = Vec3::Zero()) {
    const Pose X{p, Quat::Identity()};
    const AddObject add = test::solid(makeObjectId(1, 1), ShapeKind::kGroup, {}, X);
    EXPECT_EQ(scene.apply(makeCommand(CommandKind::kAddObject, add)), ErrorCode::kOk);
    const hd_object_pose pose = poseMessage(add.object, X, {v, Vec3::Zero()});
    EXPECT_EQ(scene.apply(makeCommand(CommandKind::kObjectPose, pose)), ErrorCode::kOk);
    scene.advance(1e-3);
    return makeObjectId(1, 1);
  }

 private:
  std::uint64_t seq_ = 0;
};

}  // namespace hapticd
