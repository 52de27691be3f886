// Surfaces in recordings: what a hand feels of them is felt again, textures and all.
#include <capnp/message.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "daemon/recording/block.h"
#include "daemon/recording/texture.h"
#include "daemon/scene/texture/texture_memory.h"
#include "proto/recording.capnp.h"
#include "tests/recording/taken.h"
#include "tests/support/shape/texture_upload.h"

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

/** A bench with a wall that shows what is uploaded, and a hand that rubs it. */
struct Rubbed {
  Bench bench;
  Client root = bench.core.client(bench.administration);
  int cycle = 0;

  std::uint64_t upload(const std::vector<std::byte>& bytes) {
    auto texture = parseTexture(bytes);
    EXPECT_TRUE(texture.ok());
    const auto id = bench.core.scene().textures().add(std::move(*texture), root);
    EXPECT_TRUE(id.ok());
    return *id;
  }
  /** 20 mm to and fro within a fifth of a second, 1 mm deep. */
  void rub(int cycles, std::vector<std::pair<double, double>>* felt = nullptr) {
    for (int i = 0; i < cycles; ++i) {
      bench.scripted[0]->sample.p = {0.01 * std::sin(0.0314 * cycle++), 0, -1e-3};
      bench.step();
      const hd_sample s = bench.sample();
      if (felt != nullptr) felt->push_back({s.force[0], s.by_source[HD_SOURCE_TEXTURE][0]});
    }
  }
};

/** Wider than a part of the stream, so that its order and its seams are felt. */
std::vector<std::byte> widePicture() {
  constexpr std::uint32_t kWide = 1100, kHigh = 1000;
  std::vector<std::uint16_t> pixels(std::size_t{kWide} * kHigh);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = static_cast<std::uint16_t>(30000 + 20000 * std::sin(0.03 * static_cast<double>(i % kWide)) *
                                                       std::cos(0.02 * static_cast<double>(i / kWide)));
  return reliefUpload(kWide, kHigh, pixels);
}

TEST(RecordingSurfaces, TexturesAreInItAndTheReplayFeelsThem) {
  Rubbed rubbed;
  Bench& bench = rubbed.bench;
  SurfaceSpec shown;
  shown.relief = rubbed.upload(widePicture());
  shown.relief_depth = 5e-4;
  shown.relief_width = shown.relief_height = 0.05;
  shown.vibration = rubbed.upload(vibrationUpload());
  ObjectSpec spec = wall();
  spec.surface = shown;
  ASSERT_TRUE(bench.core.scene().create(spec, rubbed.root).ok());
  const Session* session = bench.live(bench.administration);
  ASSERT_NE(session, nullptr);
  ASSERT_TRUE(bench.core.acquireLease(session->id).ok());
  bench.scripted[0]->sample.p = {0, 0, 0.01};
  bench.step(5);
  Taken taken(bench);
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.step(40);
  std::vector<std::pair<double, double>> felt;
  rubbed.rub(300, &felt);
  // Another one takes the place while it is recorded.
  SurfaceSpec other = shown;
  other.relief = rubbed.upload(reliefUpload(3, 2, {0, 65535, 0, 65535, 0, 65535}));
  other.relief_depth = 1e-3;
  ASSERT_TRUE(bench.core.scene().setSurface("wall", other).ok());
  rubbed.rub(200, &felt);
  double least = 0, most = 0;
  for (const auto& [sent, texture] : felt) {
    least = std::min(least, texture);
    most = std::max(most, texture);
  }
  EXPECT_GT(most - least, 0.01) << "nothing of a texture was felt";
  const std::string bytes = taken.finish([&] { bench.step(); });
  const auto verdict = verify(*replayerOf(bytes));
  ASSERT_TRUE(verdict.ok()) << toString(verdict.error());
  EXPECT_GT(verdict->cycles, 500u);
  EXPECT_EQ(verdict->differing, 0u) << verdict->first;
  // The test must be able to fail: without a texture's part the replay feels something else.
  auto reader = readerOf(bytes);
  ASSERT_TRUE(reader.ok());
  std::size_t textures = 0;
  RecordedCycle cycle;
  while (*reader->next(cycle)) textures += reader->takeTextures().size();
  EXPECT_EQ(textures, 3u);
}

TEST(RecordingSurfaces, EffectsAreInItAndTheReplayFeelsThem) {
  Rubbed rubbed;
  Bench& bench = rubbed.bench;
  const auto show = [&](const char* name, EffectKind kind, double seconds) {
    ObjectSpec spec;
    spec.name = name;
    ASSERT_TRUE(bench.core.scene().create(spec, rubbed.root).ok());
    EffectSpec effect;
    effect.kind = kind;
    effect.duration_s = seconds;
    ASSERT_TRUE(bench.core.scene().setEffect(name, effect, bench.core.now()).ok());
  };
  show("hint", EffectKind::kGuide, 0);
  show("buzz", EffectKind::kVibration, 0.2);
  show("drag", EffectKind::kFriction, 0);
  const Session* session = bench.live(bench.administration);
  ASSERT_NE(session, nullptr);
  ASSERT_TRUE(bench.core.acquireLease(session->id).ok());
  bench.step(5);
  Taken taken(bench);
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.step(40);
  rubbed.rub(300);
  show("late", EffectKind::kForce, 0.05);
  rubbed.rub(200);
  EXPECT_GT(std::abs(bench.sample().by_source[HD_SOURCE_EFFECT][0]), 0.1);
  const auto verdict = verify(*replayerOf(taken.finish([&] { bench.step(); })));
  ASSERT_TRUE(verdict.ok()) << toString(verdict.error());
  EXPECT_GT(verdict->cycles, 500u);
  EXPECT_EQ(verdict->differing, 0u) << verdict->first;
}

/** Slower or faster, lighter or heavier than all that triangles name: neither the servo nor a replay minds it. */
TEST(RecordingSurfaces, AModelThatNoTriangleNamesBoundsNothing) {
  const auto texture = parseTexture(vibrationUpload({{{0.02, 0.2, 1}, {-0.9, 0.2}},
                                                     {{0.001, 0.01, 1}, {0, 0}},
                                                     {{0.3, 0.2, 4}, {-0.5, 0}},
                                                     {{0.02, 3, 9}, {0.1, -0.1}},
                                                     {{5, 50, 1}, {0, 0}}},
                                                    {0, 2, 3}));
  ASSERT_TRUE(texture.ok());
  const auto live = layOut(*texture, kMs, false);
  ASSERT_TRUE(live.ok());
  capnp::MallocMessageBuilder message;
  auto part = message.initRoot<proto::TexturePart>();
  writePart(0, *live->view(), 0, part);
  auto kept = TextureParts().take(part.asReader());
  ASSERT_TRUE(kept.ok() && kept->has_value());
  const TextureView replayed = (*kept)->view();
  for (const VibrationView* view : {&live->view()->vibration, &replayed.vibration}) {
    EXPECT_EQ(view->least_speed, 0.02);
    EXPECT_EQ(view->most_speed, 0.3);
    EXPECT_EQ(view->least_force, 0.2);
    EXPECT_EQ(view->most_force, 3);
  }
}

/** Parts of one texture in a recording of one cycle, as somebody might write them. */
std::string readBack(const std::function<void(capnp::MessageBuilder&, int)>& part, int parts) {
  std::string bytes;
  RecordingWriter writer([&](std::span<const std::byte> block) {
    bytes.append(reinterpret_cast<const char*>(block.data()), block.size());
    return true;
  });
  RecordingHeader header;
  header.devices = {{"sim", "sim://default", "a simulation"}};
  (void)writer.header(header);
  for (int i = 0; i < parts; ++i) {
    capnp::MallocMessageBuilder message;
    part(message, i);
    const std::vector<std::byte> block = encodeBlock(static_cast<std::uint64_t>(i) + 1, message);
    bytes.append(reinterpret_cast<const char*>(block.data()), block.size());
  }
  auto reader = readerOf(bytes);
  EXPECT_TRUE(reader.ok());
  RecordedCycle cycle;
  const auto more = reader->next(cycle);
  return more.ok() ? "" : more.error().what;
}

proto::ReliefPart::Builder relief(capnp::MessageBuilder& message, std::uint32_t entry, std::uint32_t width,
                                  std::uint32_t height, std::uint32_t offset, unsigned pixels) {
  auto part = message.initRoot<proto::Block>().initTexturePart();
  part.setEntry(entry);
  auto out = part.initRelief();
  out.setWidth(width);
  out.setHeight(height);
  out.setOffset(offset);
  out.initPixels(pixels);
  return out;
}

TEST(RecordingSurfaces, PartsThatAreNoTextureAreRefused) {
  using Message = capnp::MessageBuilder;
  EXPECT_EQ(readBack([](Message& m, int) { relief(m, 0, 2, 2, 0, 4); }, 1), "");
  EXPECT_EQ(readBack([](Message& m, int i) { relief(m, 0, 2, 4, i == 0 ? 0 : 4, 4); }, 2), "");
  const char* kOrder = "texturePart: it does not follow the part before it";
  EXPECT_EQ(readBack([](Message& m, int) { relief(m, 0, 2, 2, 0, 5); }, 1), kOrder);
  EXPECT_EQ(readBack([](Message& m, int) { relief(m, 0, 2, 2, 0, 0); }, 1), kOrder);
  EXPECT_EQ(readBack([](Message& m, int) { relief(m, 0, 2, 4, 0, 4); }, 2), kOrder) << "the first part twice";
  EXPECT_EQ(readBack([](Message& m, int i) { relief(m, i == 0 ? 0 : 1, 2, 4, i == 0 ? 0 : 4, 4); }, 2), kOrder);
  EXPECT_EQ(readBack([](Message& m, int) { relief(m, 0, 1, 2, 0, 2); }, 1), "texturePart: a relief of 1 x 2 pixels");
  EXPECT_EQ(readBack([](Message& m, int) { relief(m, 0, 5000, 2, 0, 2); }, 1),
            "texturePart: a relief of 5000 x 2 pixels");
  EXPECT_EQ(readBack([](Message& m, int) { relief(m, kMaxTextures, 2, 2, 0, 4); }, 1),
            "texturePart: entry " + std::to_string(kMaxTextures) + " of the texture table");
  const auto vibration = [](unsigned models, unsigned coefficients, double reflection, double power,
                            std::vector<std::uint16_t> corners) {
    return readBack(
        [&](Message& m, int) {
          auto out = m.initRoot<proto::Block>().initTexturePart().initVibration();
          auto all = out.initModels(models);
          for (unsigned k = 0; k < models; ++k) {
            auto model = all[k];
            model.setSpeed(k == 1 ? 0.3 : 0.1);
            model.setForce(k == 2 ? 3 : 1);
            model.setPower(power);
            auto reflections = model.initReflection(coefficients);
            for (unsigned i = 0; i < coefficients; ++i) reflections.set(i, reflection);
          }
          auto list = out.initTriangles(static_cast<unsigned>(corners.size()));
          for (unsigned i = 0; i < list.size(); ++i) list.set(i, corners[i]);
        },
        1);
  };
  EXPECT_EQ(vibration(3, 16, 0.5, 1, {0, 1, 2}), "");
  EXPECT_EQ(vibration(3, 16, 1.0, 1, {0, 1, 2}), "texturePart: model 0 is unstable");
  EXPECT_EQ(vibration(3, 15, 0.5, 1, {0, 1, 2}), "texturePart: model 0 has 15 coefficients, not 16");
  EXPECT_EQ(vibration(3, 16, 0.5, -1, {0, 1, 2}),
            "texturePart: model 0 has no speed, force or power that there can be");
  EXPECT_EQ(vibration(3, 16, 0.5, 1, {0, 1, 3}), "texturePart: triangle 0 has no model 3");
  EXPECT_EQ(vibration(4, 16, 0.5, 1, {0, 1, 2, 0, 3, 1}), "texturePart: triangle 1 has no area");
  EXPECT_EQ(vibration(3, 16, 0.5, 1, {0, 1}), "texturePart: 2 corners of triangles");
  EXPECT_EQ(vibration(2, 16, 0.5, 1, {0, 1, 1}), "texturePart: 2 models");
}

}  // namespace
}  // namespace hapticd::test
