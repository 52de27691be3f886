#include "daemon/scene/texture/texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/scene/texture/texture_memory.h"
#include "tests/support/shape/texture_upload.h"

namespace hapticd {
namespace {

using test::reliefUpload;
using test::vibrationUpload;
using ::testing::HasSubstr;

TEST(Texture, AReliefKeepsItsPixelsAndKnowsItsSteepestSteps) {
  const std::vector<std::uint16_t> pixels{0, 100, 50, 60, 70, 65535};
  auto texture = parseTexture(reliefUpload(3, 2, pixels));
  ASSERT_TRUE(texture.ok());
  EXPECT_EQ(texture->relief.pixels, pixels);
  EXPECT_DOUBLE_EQ(texture->relief.across.grey, (65535 - 70) / 65535.0);
  EXPECT_EQ(texture->relief.across.column, 1u);
  EXPECT_EQ(texture->relief.across.row, 1u);
  EXPECT_DOUBLE_EQ(texture->relief.down.grey, (65535 - 50) / 65535.0);
  EXPECT_EQ(texture->relief.down.column, 2u);
  EXPECT_EQ(texture->relief.down.row, 0u);
  auto memory = layOut(*texture, 1'000'000, false);
  ASSERT_TRUE(memory.ok());
  EXPECT_EQ(memory->view()->relief.pixel[5], 65535);
  EXPECT_EQ(memory->view()->vibration.model, nullptr);
}

TEST(Texture, AVibrationIsLaidOutForTheServosRate) {
  auto texture = parseTexture(vibrationUpload());
  ASSERT_TRUE(texture.ok());
  ASSERT_EQ(texture->vibration.models.size(), 3u);
  EXPECT_EQ(texture->vibration.models[2].force, 3);
  auto slow = layOut(*texture, 1'000'000, false), fast = layOut(*texture, 250'000, false);
  ASSERT_TRUE(slow.ok() && fast.ok());
  const VibrationView& view = slow->view()->vibration;
  EXPECT_EQ(view.triangles, 1u);
  EXPECT_EQ(view.triangle[0][2], 2);
  EXPECT_EQ(view.most_speed, 0.3);
  EXPECT_EQ(view.least_force, 0.2);
  EXPECT_LT(view.model[0].power, fast->view()->vibration.model[0].power) << "a slower servo plays less of it";
}

/** Each fault is named, and nothing else is said of the texture. */
TEST(Texture, EveryFaultIsNamed) {
  const auto relief = reliefUpload(2, 2, {1, 2, 3, 4});
  const auto vibration = vibrationUpload();
  const auto with = [](std::vector<std::byte> bytes, std::size_t at, auto value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return bytes;
  };
  const auto cut = [](std::vector<std::byte> bytes, std::size_t by) {
    bytes.resize(bytes.size() - by);
    return bytes;
  };
  const std::size_t model = sizeof(hd_vibration_upload), second = model + sizeof(hd_vibration_model) + 16;
  const std::size_t triangle = model + 3 * (sizeof(hd_vibration_model) + 16);
  const double nan = std::nan("");
  const struct {
    const char* where;
    std::vector<std::byte> bytes;
  } faults[] = {
      {"texture.bytes", {}},
      {"texture.bytes", cut(relief, 1)},
      {"texture.bytes", cut(vibration, 4)},
      {"texture.magic", with(relief, 0, 0)},
      {"texture.kind", with(relief, 8, 3u)},
      {"texture.reserved", with(relief, 12, 1u)},
      {"relief.width", with(relief, 16, 1u)},
      {"relief.width", with(relief, 16, 4097u)},
      {"relief.height", with(relief, 20, 0xffffffffu)},
      {"texture.bytes", with(relief, 20, 3u)},
      {"vibration.models", with(vibration, 16, 2u)},
      {"vibration.models", with(vibration, 16, 257u)},
      {"vibration.triangles", with(vibration, 20, 0u)},
      {"vibration.order", with(vibration, 24, 33u)},
      {"vibration.rate_hz", with(vibration, 32, nan)},
      {"vibration.rate_hz", with(vibration, 32, 1e6)},
      {"vibration.model[0].speed", with(vibration, model, -1.0)},
      {"vibration.model[1].force", with(vibration, second + 8, 1e3)},
      {"vibration.model[1].variance", with(vibration, second + 16, nan)},
      {"vibration.model[0].a[1]", with(vibration, model + 32, nan)},
      {"vibration.model[1].a", with(vibration, second + 32, 1.5)},
      {"vibration.triangle[0]", with(vibration, triangle, 3u)},
      {"vibration.triangle[0]", with(vibration, triangle + 4, 0u)},
  };
  for (const auto& fault : faults) {
    const auto texture = parseTexture(fault.bytes);
    ASSERT_FALSE(texture.ok()) << fault.where;
    EXPECT_EQ(texture.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(texture.error().where, fault.where) << texture.error().what;
    EXPECT_FALSE(texture.error().what.empty());
  }
}

}  // namespace
}  // namespace hapticd
