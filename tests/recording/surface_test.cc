// Surfaces in recordings: what needs no texture is kept, and a shown texture is a reason to refuse.
#include <gtest/gtest.h>

#include "tests/recording/taken.h"
#include "tests/support/texture_upload.h"

namespace hapticd::test {
namespace {

ObjectSpec wall() {
  ObjectSpec spec;
  spec.name = "wall";
  spec.shape.kind = ShapeKind::kPlane;
  spec.material = kDefaultMaterial;
  spec.surface.transient_gain = 12;
  spec.surface.smooth_deg = 30;
  return spec;
}

TEST(RecordingSurfaces, TransientsAndShadingAreKept) {
  Bench bench;
  const auto id = bench.core.scene().create(wall(), bench.core.client(bench.administration));
  ASSERT_TRUE(id.ok());
  bench.step(5);
  const Cycle& cycle = bench.core.devices().links().front()->group().servo().cycle();
  const SurfaceParameters before = cycle.scene().find(*id)->surface.parameters;
  EXPECT_EQ(before.transient_gain, 12);
  Taken taken(bench);
  const SceneObject* now = cycle.scene().find(*id);
  ASSERT_NE(now, nullptr);
  EXPECT_EQ(now->surface.parameters.transient_turn, before.transient_turn);
  EXPECT_EQ(now->surface.parameters.smooth_cosine, before.smooth_cosine);
  bench.step(20);
  const auto verdict = verify(*replayerOf(taken.finish([&] { bench.step(); })));
  ASSERT_TRUE(verdict.ok());
  EXPECT_EQ(verdict->differing, 0u) << verdict->first;
}

TEST(RecordingSurfaces, AShownTextureIsAReasonToRefuse) {
  Bench bench;
  const Client root = bench.core.client(bench.administration);
  auto texture = parseTexture(testing::reliefUpload(2, 2, {1, 2, 3, 4}));
  ASSERT_TRUE(texture.ok());
  const auto id = bench.core.scene().textures().add(std::move(*texture), root);
  ASSERT_TRUE(id.ok());
  ObjectSpec spec = wall();
  spec.surface.relief = *id;
  ASSERT_TRUE(bench.core.scene().create(spec, root).ok());
  bench.step(5);
  const auto refused = bench.core.record("", bench.administration);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(refused.error().where, "/textures/" + std::to_string(*id));
  ASSERT_TRUE(bench.core.scene().setSurface("wall", SurfaceSpec{}).ok());
  bench.step(5);
  Taken taken(bench);
  EXPECT_FALSE(taken.finish([&] { bench.step(); }).empty());
}

}  // namespace
}  // namespace hapticd::test
