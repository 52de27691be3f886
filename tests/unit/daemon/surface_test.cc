#include "daemon/scene/surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "daemon/scene/scene_model.h"
#include "rt/render/surface/relief.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/shape/texture_upload.h"
#include "tests/unit/daemon/fake_sink.h"

namespace hapticd {
namespace {

using test::FakeSink;
using ::testing::HasSubstr;

/** A scene with two servos of different rates. */
struct SurfaceModel : ::testing::Test {
  SurfaceModel() {
    fast.period_ns = 250'000;
    scene.textures().setLock(false);
    for (FakeSink* sink : {&slow, &fast}) {
      EXPECT_TRUE(scene.textures().attach(*sink).ok());
      scene.attach(*sink);
    }
    client.uid = 7;
    client.connection = 1;
    spec.name = "wall";
    spec.shape.kind = ShapeKind::kPlane;
    spec.material = kDefaultMaterial;
  }
  std::uint64_t add(const std::vector<std::byte>& upload) {
    auto texture = parseTexture(upload);
    return texture.ok() ? scene.textures().add(std::move(*texture), client).value() : 0;
  }
  /** 0 to 255 and back: a step of one grey of 256 between neighbours, but for one of 16. */
  std::uint64_t addRelief() {
    std::vector<std::uint16_t> pixels(64, 1000);
    pixels[3 * 8 + 4] = 1000 + 16 * 257;
    return add(test::reliefUpload(8, 8, pixels));
  }
  static const SurfaceParameters& last(const FakeSink& sink) {
    EXPECT_EQ(sink.orders.back().kind, CommandKind::kSetSurface);
    return sink.orders.back().as<SetSurface>().surface;
  }

  MeshStore meshes;
  SceneModel scene{meshes};
  FakeSink slow, fast;
  Client client;
  ObjectSpec spec;
};

TEST_F(SurfaceModel, APlainSurfaceSendsNothingAndASetOneWhatEachServoNeeds) {
  ASSERT_TRUE(scene.create(spec, client).ok());
  EXPECT_EQ(slow.orders.back().kind, CommandKind::kAddObject);
  SurfaceSpec surface;
  surface.smooth_deg = 60;
  surface.transient_gain = 12;
  ASSERT_TRUE(scene.setSurface("wall", surface).ok());
  EXPECT_EQ(scene.find("wall")->spec.surface, surface);
  EXPECT_NEAR(last(slow).smooth_cosine, 0.5, 1e-15);
  EXPECT_EQ(last(slow).transient_gain, 12);
  const struct {
    const FakeSink& sink;
    double period;
  } servos[] = {{slow, 1e-3}, {fast, 0.25e-3}};
  for (const auto& servo : servos) {
    const double r = std::exp(-servo.period / 0.01), theta = 2 * std::numbers::pi * 150 * servo.period;
    EXPECT_NEAR(last(servo.sink).transient_first, r * std::sin(theta), 1e-15);
    EXPECT_NEAR(last(servo.sink).transient_turn, 2 * r * std::cos(theta), 1e-15);
    EXPECT_NEAR(last(servo.sink).transient_decay, r * r, 1e-15);
  }
}

TEST_F(SurfaceModel, AServoThatComesLaterGetsSurfacesAndTextures) {
  spec.surface.relief = addRelief();
  ASSERT_TRUE(scene.create(spec, client).ok());
  FakeSink late;
  ASSERT_TRUE(scene.textures().attach(late).ok());
  scene.attach(late);
  const std::uint32_t reference = last(late).relief;
  ASSERT_NE(reference, 0u);
  ASSERT_NE(late.meshes().texture(reference - 1), nullptr);
  EXPECT_EQ(late.meshes().texture(reference - 1)->relief.width, 8u);
  scene.detach(late);
  scene.textures().detach(late);
}

/** To lay out many models takes so long that a watchdog barks, if a servo that comes late has them all made anew. */
TEST_F(SurfaceModel, ServosOfOneRateReadOneCopy) {
  const TextureInfo* vibration = scene.textures().find(add(test::vibrationUpload()));
  ASSERT_NE(vibration, nullptr);
  EXPECT_EQ(scene.textures().lockedBytes(), 2 * vibration->bytes);
  EXPECT_EQ(scene.textures().bytesOf(client.uid), 3 * vibration->bytes) << "with what was uploaded";
  const std::uint64_t before = scene.textures().lockedBytes();
  const TextureInfo* relief = scene.textures().find(addRelief());
  ASSERT_NE(relief, nullptr);
  EXPECT_EQ(scene.textures().lockedBytes(), before + relief->bytes) << "it is the same at any rate";
  const auto texture = [](FakeSink& sink, const TextureInfo* info) {
    return sink.meshes().texture(static_cast<std::uint32_t>(info->id) - 1);
  };
  FakeSink late;
  ASSERT_TRUE(scene.textures().attach(late).ok());
  EXPECT_EQ(texture(late, vibration), texture(slow, vibration));
  EXPECT_NE(texture(late, vibration), texture(fast, vibration));
  EXPECT_EQ(texture(late, relief), texture(fast, relief));
  EXPECT_EQ(scene.textures().lockedBytes(), before + relief->bytes);
  scene.textures().detach(slow);
  EXPECT_EQ(texture(late, vibration)->vibration.triangles, 1u) << "it stays as long as one reads it";
  EXPECT_EQ(scene.textures().lockedBytes(), before + relief->bytes);
  scene.textures().detach(late);
  EXPECT_EQ(scene.textures().lockedBytes(), vibration->bytes + relief->bytes);
}

TEST_F(SurfaceModel, EveryNumberHasItsBounds) {
  ASSERT_TRUE(scene.create(spec, client).ok());
  const std::size_t orders = slow.orders.size();
  const struct {
    const char* where;
    double SurfaceSpec::*field;
    double bad;
  } faults[] = {{"surface.smoothDeg", &SurfaceSpec::smooth_deg, 91},
                {"surface.smoothDeg", &SurfaceSpec::smooth_deg, std::nan("")},
                {"surface.transientGain", &SurfaceSpec::transient_gain, -1},
                {"surface.transientHz", &SurfaceSpec::transient_hz, 401},
                {"surface.transientDecay", &SurfaceSpec::transient_decay_s, 0},
                {"surface.reliefDepth", &SurfaceSpec::relief_depth, 1},
                {"surface.reliefWidth", &SurfaceSpec::relief_width, 0},
                {"surface.reliefHeight", &SurfaceSpec::relief_height, 100},
                {"surface.vibrationMass", &SurfaceSpec::vibration_mass, INFINITY}};
  for (const auto& fault : faults) {
    SurfaceSpec surface;
    surface.*fault.field = fault.bad;
    const auto set = scene.setSurface("wall", surface);
    ASSERT_FALSE(set.ok()) << fault.where;
    EXPECT_EQ(set.error().where, fault.where);
    EXPECT_EQ(set.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(set.error().remedy, "") << fault.where;
  }
  EXPECT_EQ(slow.orders.size(), orders) << "a refusal changes nothing";
  EXPECT_EQ(scene.find("wall")->spec.surface, SurfaceSpec{});
}

TEST_F(SurfaceModel, AReliefTooSteepNamesThePixelAndTheDepthThatWouldDo) {
  ASSERT_TRUE(scene.create(spec, client).ok());
  SurfaceSpec surface;
  surface.relief = addRelief();
  surface.relief_width = surface.relief_height = 0.008;  // Pixels of 1 mm, a step of 16/255 of the depth.
  surface.relief_depth = 0.01;
  EXPECT_TRUE(scene.setSurface("wall", surface).ok());
  surface.relief_width = 0.002;
  const auto set = scene.setSurface("wall", surface);
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().where, "surface.reliefDepth");
  EXPECT_THAT(set.error().what, HasSubstr("right of pixel 3,3"));
  EXPECT_THAT(set.error().what, HasSubstr("2.51"));
  EXPECT_THAT(set.error().remedy, HasSubstr("0.00796"));
  surface.relief_depth = 0.00796;
  EXPECT_TRUE(scene.setSurface("wall", surface).ok());
}

TEST_F(SurfaceModel, AReliefTooSteepAslantIsRefusedToo) {
  ASSERT_TRUE(scene.create(spec, client).ok());
  std::vector<std::uint16_t> pixels;  // It rises by as much to the right as downward.
  for (std::uint32_t i = 0; i < 64; ++i) pixels.push_back(static_cast<std::uint16_t>(4000 * (i % 8 + i / 8)));
  SurfaceSpec surface;
  surface.relief = add(test::reliefUpload(8, 8, pixels));
  surface.relief_width = surface.relief_height = 0.004;
  surface.relief_depth = 1.9 / std::sqrt(2.0) * 65535 * 0.0005 / 4000;  // A slope of 1.9 aslant.
  EXPECT_TRUE(scene.setSurface("wall", surface).ok());
  surface.relief_depth *= 2.5 / 1.9;  // Of 1.77 along each side.
  const auto set = scene.setSurface("wall", surface);
  ASSERT_FALSE(set.ok());
  EXPECT_THAT(set.error().what, HasSubstr("the surface at pixel "));
  EXPECT_THAT(set.error().what, HasSubstr("has a slope of 2.5; 2 is the most"));
  EXPECT_THAT(set.error().remedy, HasSubstr("make the depth at most 0.0115 m"));
}

TEST_F(SurfaceModel, AReliefIsNowhereSteeperThanItsSlopes) {
  std::mt19937 random(seedOf(11));
  std::uniform_real_distribution<double> number(-1, 1);
  for (int picture = 0; picture < 40; ++picture) {
    const std::uint32_t width = 2 + random() % 6, height = 2 + random() % 6;
    const double blur = picture % 4;
    const Vec3 wave(number(random), number(random), 3 * number(random));
    const test::TestRelief t(width, height, [&](auto x, auto y) {
      const double smooth = 0.5 + 0.5 * std::sin(wave.x() * x + wave.y() * y + wave.z());
      return (blur * smooth + 0.5 + 0.5 * number(random)) / (blur + 1);
    });
    SurfaceParameters laid{};
    laid.relief_depth = 1e-3;
    laid.relief_size[0] = 0.001 * width * std::exp(number(random));
    laid.relief_size[1] = 0.001 * height * std::exp(number(random));
    double bound = 0;
    for (const ReliefSlope& slope : reliefSlopes(t.pixels, width, height)) {
      bound = std::max(bound, 1e-3 * std::hypot(slope.across * width / laid.relief_size[0],
                                                slope.down * height / laid.relief_size[1]));
    }
    double steepest = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 x(number(random) * laid.relief_size[0], number(random) * laid.relief_size[1], number(random));
      steepest = std::max(steepest, reliefAt(t.view.relief, laid, x, Vec3::UnitZ()).gradient.norm());
      const Vec3 n = Vec3(number(random), number(random), number(random)).normalized();
      ASSERT_LE(reliefAt(t.view.relief, laid, x, n).gradient.norm(), bound * (1 + 1e-9)) << picture;
    }
    EXPECT_LE(steepest, bound * (1 + 1e-9)) << picture;
    EXPECT_GE(steepest, 0.5 * bound) << picture << ": refused without need";
  }
}

TEST_F(SurfaceModel, TheDepthThatIsAdvisedIsTaken) {
  ASSERT_TRUE(scene.create(spec, client).ok());
  SurfaceSpec surface;
  surface.relief = addRelief();
  const std::string before = "make the depth at most ";
  for (int i = 0; i < 2000; ++i) {
    surface.relief_depth = 0.02;
    surface.relief_width = 1.2e-4 * std::pow(30, i / 2000.0);
    surface.relief_height = surface.relief_width * (0.9 + 0.1 * (i % 3));  // Steepest across, alike, or down.
    const auto refused = scene.setSurface("wall", surface);
    ASSERT_FALSE(refused.ok());
    const std::string& remedy = refused.error().remedy;
    ASSERT_EQ(remedy.rfind(before, 0), 0u) << remedy;
    surface.relief_depth = std::stod(remedy.substr(before.size()));
    ASSERT_TRUE(scene.setSurface("wall", surface).ok()) << remedy << ", of " << surface.relief_width;
    surface.relief_depth *= 1.011;  // Nor is it much less than what would do.
    ASSERT_FALSE(scene.setSurface("wall", surface).ok()) << remedy;
  }
}

TEST_F(SurfaceModel, TexturesAreOfTheirKindAndThere) {
  ASSERT_TRUE(scene.create(spec, client).ok());
  SurfaceSpec surface;
  surface.vibration = addRelief();
  EXPECT_THAT(scene.setSurface("wall", surface).error().what, HasSubstr("is a relief"));
  surface.vibration = 0;
  surface.relief = add(test::vibrationUpload());
  EXPECT_THAT(scene.setSurface("wall", surface).error().what, HasSubstr("is a vibration"));
  surface.relief = 99;
  EXPECT_EQ(scene.setSurface("wall", surface).error().code, ErrorCode::kNotFound);
}

TEST_F(SurfaceModel, AShownTextureStaysUntilEveryServoHasPassed) {
  spec.surface.relief = addRelief();
  ASSERT_TRUE(scene.create(spec, client).ok());
  const std::uint64_t id = spec.surface.relief;
  const std::uint32_t entry = last(slow).relief - 1;
  EXPECT_EQ(scene.textures().drop(id, client).error().code, ErrorCode::kInvalidArgument) << "it is shown";
  ASSERT_TRUE(scene.setSurface("wall", SurfaceSpec{}).ok());
  Client other = client;
  other.uid = 8;
  EXPECT_EQ(scene.textures().drop(id, other).error().code, ErrorCode::kPermissionDenied);
  ASSERT_TRUE(scene.textures().drop(id, client).ok());
  EXPECT_EQ(scene.textures().drop(id, client).error().code, ErrorCode::kNotFound);
  slow.taken = slow.orders.size();
  scene.textures().reclaim();
  EXPECT_NE(fast.meshes().texture(entry), nullptr) << "one servo may still read it";
  EXPECT_NE(scene.textures().lockedBytes(), 0u);
  fast.taken = fast.orders.size();
  scene.textures().reclaim();
  EXPECT_EQ(fast.meshes().texture(entry), nullptr);
  EXPECT_EQ(scene.textures().lockedBytes(), 0u);
}

TEST_F(SurfaceModel, ATextureGoesWithItsMakerOnceNothingShowsIt) {
  spec.surface.relief = addRelief();
  spec.keep = true;
  const std::uint64_t unused = add(test::vibrationUpload());
  ASSERT_TRUE(scene.create(spec, client).ok());
  scene.clientLeft(1);
  scene.textures().dropUnusedOf(1);
  EXPECT_EQ(scene.textures().find(unused), nullptr);
  ASSERT_NE(scene.textures().find(spec.surface.relief), nullptr) << "the wall was to be kept";
  client.administration = true;
  ASSERT_TRUE(scene.remove("wall", client).ok());
  EXPECT_EQ(scene.textures().find(spec.surface.relief), nullptr);
}

}  // namespace
}  // namespace hapticd
