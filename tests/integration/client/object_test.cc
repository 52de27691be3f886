// Whatever a program says of an object is what the daemon has, field by field, and what the program is told again.
#include <gtest/gtest.h>

#include <cstdint>
#include <hapticclient/hapticclient.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/client/maker.h"

namespace hapticd::test {
namespace {

class ObjectFields : public Maker {
 protected:
  /** As the daemon has it: by its own name, and not by the structures of the library. */
  std::string told(const std::string& name, const char* field) {
    const auto text = client_->get("/objects/" + name + "/" + field);
    return text ? std::string(*text) : text.error().message();
  }
  static const char* yes(bool is) { return is ? "true" : "false"; }
  void expectFlags(const std::string& name, std::uint32_t flags) {
    EXPECT_EQ(told(name, "enabled"), yes((flags & HAPTIC_OBJECT_ENABLED) != 0)) << flags;
    EXPECT_EQ(told(name, "visible"), yes((flags & HAPTIC_OBJECT_VISIBLE) != 0)) << flags;
    EXPECT_EQ(told(name, "twosided"), yes((flags & HAPTIC_OBJECT_TWO_SIDED) != 0)) << flags;
    EXPECT_EQ(told(name, "keep"), yes((flags & HAPTIC_OBJECT_KEEP) != 0)) << flags;
    const auto state = client_->scene().find(name);
    ASSERT_TRUE(state) << state.error().message();
    EXPECT_EQ((*state)->object->flags, flags);
  }
};

/** Half a turn about an axis askew: each entry is another number. */
constexpr haptic_pose kPose = {{0.01, -0.02, 0.03}, {0.1, 0.7, -0.5, 0.5}};
constexpr const char *kPos = "[0.01,-0.02,0.03]", *kRot = "[0.1,0.7,-0.5,0.5]";
constexpr haptic_material kMaterial = {700, 2, 0.5, 0.25};
constexpr const char* kTold = R"({"damping":2.0,"friction_dynamic":0.25,"friction_static":0.5,"stiffness":700.0})";

void expectSame(const haptic_object& object) {
  for (int i = 0; i < 3; ++i) EXPECT_EQ(object.pose.p[i], kPose.p[i]);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(object.pose.q[i], kPose.q[i]);
  EXPECT_EQ(object.material.stiffness, kMaterial.stiffness);
  EXPECT_EQ(object.material.damping, kMaterial.damping);
  EXPECT_EQ(object.material.friction_static, kMaterial.friction_static);
  EXPECT_EQ(object.material.friction_dynamic, kMaterial.friction_dynamic);
}

TEST_F(ObjectFields, OfOneThatIsMade) {
  haptic_object parent = HAPTIC_OBJECT_INIT;
  parent.name = "parent";
  const auto above = client_->scene().create(parent);
  ASSERT_TRUE(above) << above.error().message();
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = "it";
  object.parent = "parent";
  object.shape = {HAPTIC_SHAPE_BOX, 0, {0.01, 0.02, 0.03}, 0};
  object.pose = kPose;
  object.material = kMaterial;
  const auto made = client_->scene().create(object);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ(told("it", "parent"), "\"parent\"");
  EXPECT_EQ(told("it", "pos"), kPos);
  EXPECT_EQ(told("it", "rot"), kRot);
  EXPECT_EQ(told("it", "material"), kTold);
  EXPECT_EQ(told("it", "shape"), R"({"half_extents":[0.01,0.02,0.03],"kind":"box"})");
  const auto state = made->state();
  ASSERT_TRUE(state) << state.error().message();
  EXPECT_STREQ((*state)->object->parent, "parent");
  expectSame(*(*state)->object);
  EXPECT_EQ((*state)->object->shape.kind, std::uint32_t{HAPTIC_SHAPE_BOX});
  for (int i = 0; i < 3; ++i) EXPECT_EQ((*state)->object->shape.size[i], object.shape.size[i]);
}

TEST_F(ObjectFields, OfOneThatIsChanged) {
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = "it";
  auto made = client_->scene().create(object);
  ASSERT_TRUE(made) << made.error().message();
  ASSERT_TRUE(made->setPose(kPose));
  ASSERT_TRUE(made->setMaterial(kMaterial));
  ASSERT_TRUE(made->setShape({HAPTIC_SHAPE_CAPSULE, 0, {0.01, 0.02, 0}, 0}));
  EXPECT_EQ(told("it", "pos"), kPos);
  EXPECT_EQ(told("it", "rot"), kRot);
  EXPECT_EQ(told("it", "material"), kTold);
  EXPECT_EQ(told("it", "shape"), R"({"half_length":0.02,"kind":"capsule","radius":0.01})");
  const auto state = made->state();
  ASSERT_TRUE(state) << state.error().message();
  expectSame(*(*state)->object);

  haptic_surface surface = HAPTIC_SURFACE_INIT;
  const std::vector<std::pair<const char*, double haptic_surface::*>> numbers = {
      {"smooth_deg", &haptic_surface::smooth_deg},       {"transient_gain", &haptic_surface::transient_gain},
      {"transient_hz", &haptic_surface::transient_hz},   {"transient_decay_s", &haptic_surface::transient_decay_s},
      {"relief_depth", &haptic_surface::relief_depth},   {"relief_width", &haptic_surface::relief_width},
      {"relief_height", &haptic_surface::relief_height}, {"vibration_mass", &haptic_surface::vibration_mass}};
  const double values[] = {30, 0.5, 250, 0.0625, 0.00025, 0.125, 0.0625, 0.015625};
  const char* const texts[] = {"30.0", "0.5", "250.0", "0.0625", "0.00025", "0.125", "0.0625", "0.015625"};
  for (std::size_t i = 0; i < numbers.size(); ++i) surface.*numbers[i].second = values[i];
  const auto set = made->setSurface(surface);
  ASSERT_TRUE(set) << set.error().message();
  const auto after = made->state();
  ASSERT_TRUE(after) << after.error().message();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(told("it", numbers[i].first), texts[i]) << numbers[i].first;
    EXPECT_EQ((*after)->surface->*numbers[i].second, values[i]) << numbers[i].first;
  }
}

TEST_F(ObjectFields, EachFlagByItself) {
  constexpr std::uint32_t kChanged = HAPTIC_OBJECT_ENABLED | HAPTIC_OBJECT_VISIBLE | HAPTIC_OBJECT_TWO_SIDED;
  for (const std::uint32_t keep : {0u, std::uint32_t{HAPTIC_OBJECT_KEEP}}) {
    for (std::uint32_t flags = 0; flags <= kChanged; ++flags) {
      haptic_object object = HAPTIC_OBJECT_INIT;
      object.name = "it";
      object.flags = flags | keep;
      auto made = client_->scene().create(object);
      ASSERT_TRUE(made) << made.error().message();
      expectFlags("it", flags | keep);
      const std::uint32_t others = kChanged & ~flags;
      ASSERT_TRUE(made->setFlags(others));
      expectFlags("it", others | keep);
    }
  }
}

}  // namespace
}  // namespace hapticd::test
