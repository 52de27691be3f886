// Every field of every message broken in turn, and each bound met from both sides.
#include "rt/ingest/validate.h"

#include <gtest/gtest.h>

#include <limits>

#include "rt/ingest/limits.h"
#include "tests/support/stepped/messages.h"

namespace hapticd {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace)

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kDevices = 2;

ErrorCode check(const hd_slot& slot) {
  Command out;
  return validate(slot, kDevices, out);
}

template <class T>
ErrorCode check(std::uint32_t kind, const T& payload) {
  return check(slotOf(kind, payload));
}

TEST(Validate, PassesEachGoodMessageUnchanged) {
  for (const Message& m : goodMessages()) {
    hd_slot slot = m.slot;
    slot.seq = 77;
    slot.at_tick = 88;
    Command out;
    out.session = 5;
    ASSERT_EQ(validate(slot, kDevices, out), ErrorCode::kOk) << m.name;
    EXPECT_EQ(static_cast<std::uint32_t>(out.kind), slot.kind);
    EXPECT_EQ(out.seq, 77u);
    EXPECT_EQ(out.at_tick, 88u);
    EXPECT_EQ(std::memcmp(out.payload, slot.payload, slot.length), 0) << m.name;
  }
}

TEST(Validate, RefusesWrongLengthsKindsAndReserved) {
  for (const Message& m : goodMessages()) {
    const auto with = [&](auto change) {
      hd_slot slot = m.slot;
      change(slot);
      return check(slot);
    };
    EXPECT_NE(with([](auto& s) { s.length = 0; }), ErrorCode::kOk) << m.name;
    EXPECT_NE(with([](auto& s) { s.length += 1; }), ErrorCode::kOk) << m.name;
    EXPECT_NE(with([](auto& s) { s.length = 0xffffffff; }), ErrorCode::kOk) << m.name;
    if (m.name != "vertices") {
      EXPECT_NE(with([](auto& s) { s.length -= 1; }), ErrorCode::kOk) << m.name;
    }
    EXPECT_NE(with([](auto& s) { s.reserved = 1; }), ErrorCode::kOk) << m.name;
    EXPECT_EQ(with([](auto& s) { s.kind = HD_COMMAND_KINDS; }), ErrorCode::kUnsupported);
    EXPECT_EQ(with([](auto& s) { s.kind = 64; }), ErrorCode::kUnsupported) << "an order of control is no message";
    EXPECT_EQ(with([](auto& s) { s.kind = HD_COMMAND_NONE; }), ErrorCode::kUnsupported);
  }
}

TEST(Validate, LeavesTheCommandAloneWhenItRefuses) {
  hd_client_force bad = goodForce();
  bad.force[1] = kNan;
  Command out;
  out.kind = CommandKind::kLimits;
  out.payload[0] = 9;
  EXPECT_NE(validate(slotOf(HD_COMMAND_CLIENT_FORCE, bad), kDevices, out), ErrorCode::kOk);
  EXPECT_EQ(out.kind, CommandKind::kLimits);
  EXPECT_EQ(out.payload[0], 9);
}

// A floating-point field with the values just inside and just outside of what it may hold.
struct Real {
  std::string message;
  std::size_t offset;
  bool single;  // float instead of double
  std::vector<double> good, bad;
};

void expectReal(const Real& field) {
  for (const Message& m : goodMessages()) {
    if (m.name != field.message) continue;
    const auto with = [&](double value) {
      hd_slot slot = m.slot;
      const auto narrow = static_cast<float>(value);
      std::memcpy(slot.payload + field.offset, field.single ? static_cast<const void*>(&narrow) : &value,
                  field.single ? sizeof narrow : sizeof value);
      return check(slot);
    };
    const std::string where = m.name + " at " + std::to_string(field.offset);
    for (const double value : field.good) EXPECT_EQ(with(value), ErrorCode::kOk) << where << ": " << value;
    for (const double value : field.bad) EXPECT_EQ(with(value), ErrorCode::kInvalidArgument) << where << ": " << value;
    for (const double value : {kNan, -kNan, kInf, -kInf}) {
      EXPECT_EQ(with(value), ErrorCode::kInvalidArgument) << where << ": " << value;
    }
    return;
  }
  FAIL() << field.message;
}

#define AT(type, field) offsetof(type, field)
#define ALONG(list, message, type, field, n, ...) \
  for (int i = 0; i < (n); ++i) (list).push_back({message, offsetof(type, field) + i * 8u, false, __VA_ARGS__})

void addMaterial(std::vector<Real>& list, const std::string& message, std::size_t base) {
  using namespace limits;  // NOLINT(google-build-using-namespace)
  list.push_back({message, base + AT(hd_material, stiffness), false, {0, kStiffness}, {-1e-9, kStiffness * 1.001}});
  list.push_back({message, base + AT(hd_material, damping), false, {0, kDamping}, {-1e-9, kDamping * 1.001}});
  list.push_back({message, base + AT(hd_material, friction_static), false, {0.4, kFriction}, {0.39, kFriction + 0.01}});
  list.push_back({message, base + AT(hd_material, friction_dynamic), false, {0, 0.6}, {-1e-9, 0.61}});
}

TEST(Validate, BoundsEveryReal) {
  using namespace limits;  // NOLINT(google-build-using-namespace)
  const double c = kCoordinate;
  std::vector<Real> all;
  ALONG(all, "pose", hd_object_pose, p, 3, {-c, c}, {-c * 1.001, c * 1.001});
  ALONG(all, "pose", hd_object_pose, v, 3, {-kSpeed, kSpeed}, {kSpeed * 1.001});
  ALONG(all, "pose", hd_object_pose, w, 3, {-kAngularSpeed, kAngularSpeed}, {-kAngularSpeed * 1.001});
  ALONG(all, "pose", hd_object_pose, q, 4, {}, {1.1, -1.1, 0.3, 1e300});
  ALONG(all, "intent", hd_intent, p, 3, {-c, c}, {-c * 1.001});
  ALONG(all, "intent", hd_intent, q, 4, {}, {1.1, 1e300});
  ALONG(all, "intent", hd_intent, gripper_rad, 1, {-kGripper, kGripper}, {kGripper * 1.001});
  ALONG(all, "limits", hd_limits, force_n, 1, {0, kForce}, {-1e-9, kForce * 1.001});
  ALONG(all, "limits", hd_limits, torque_nm, 1, {0, kTorque}, {-1e-9, kTorque * 1.001});
  ALONG(all, "force", hd_client_force, force, 3, {-900, 900}, {-kForce * 1.001, 1e300});
  ALONG(all, "force", hd_client_force, torque, 3, {-90, 90}, {kTorque * 1.001, -1e300});
  ALONG(all, "field", hd_force_field, x0, 3, {-c, c}, {-c * 1.001});
  ALONG(all, "field", hd_force_field, f0, 3, {-900, 900}, {-kForce * 1.001});
  ALONG(all, "field", hd_force_field, jacobian, 9, {-kStiffness, kStiffness}, {kStiffness * 1.001});
  ALONG(all, "field", hd_force_field, radius, 1, {kRadiusMin, c}, {0, -0.02, c * 1.001});
  for (const char* model : {"plane", "spring", "sphere", "halfspaces", "corner"}) {
    ALONG(all, model, hd_local_model, origin, 3, {-c, c}, {-c * 1.001});
    addMaterial(all, model, AT(hd_local_model, material));
  }
  addMaterial(all, "material", AT(hd_object_material, material));
  ALONG(all, "plane", hd_local_model, normal, 3, {}, {0.5, -2, 1e300});
  ALONG(all, "spring", hd_local_model, radius, 1, {0, c}, {-1e-9, c * 1.001});
  ALONG(all, "sphere", hd_local_model, radius, 1, {-c, -kRadiusMin, kRadiusMin, c}, {0, -c * 1.001, c * 1.001});
  ALONG(all, "halfspaces", hd_local_model, radius, 1, {0, 1e-9, c}, {-1e-9, c * 1.001});
  for (std::uint32_t h = 0; h < 2; ++h) {
    const std::size_t base = AT(hd_local_model, halfspace) + h * 16;
    for (std::size_t i = 0; i < 3; ++i) all.push_back({"halfspaces", base + 4 * i, true, {}, {0.3, -2}});
    all.push_back({"halfspaces", base + 12, true, {-c, c}, {-c * 1.001, c * 1.001}});
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.push_back({"vertices", AT(hd_object_vertices, move) + 16 * i + 4 + 4 * axis, true, {-c, c}, {c * 1.001}});
    }
  }
  for (const Real& field : all) expectReal(field);
  EXPECT_GT(all.size(), 90u);
}

// An integer field likewise.
struct Integer {
  std::string message;
  std::size_t offset;
  std::size_t bytes;
  std::vector<std::int64_t> good, bad;
};

TEST(Validate, BoundsEveryInteger) {
  const std::vector<std::int64_t> good_lease{1, limits::kLeaseNs};
  const std::vector<std::int64_t> bad_lease{0, -1, limits::kLeaseNs + 1, INT64_MAX, INT64_MIN};
  const std::vector<std::int64_t> good_blend{0, limits::kBlendNs};
  const std::vector<std::int64_t> bad_blend{-1, limits::kBlendNs + 1, INT64_MAX, INT64_MIN};
  const std::vector<std::int64_t> bad_slot{HD_MODEL_SLOTS, 0xffffffff};
  const std::vector<std::int64_t> bad_device{kDevices, 0xffffffff};
  std::vector<Integer> all{
      {"pose", AT(hd_object_pose, lease_us), 4, {0, 1, 0xffffffff}, {}},
      {"pose", AT(hd_object_pose, object), 4, {0, 0xffffffff}, {}},  // the cycle knows which there are
      {"material", AT(hd_object_material, reserved), 4, {0}, {1}},
      {"flags", AT(hd_object_flags, mask), 4, {0, 7}, {8, 0xffffffff}},
      {"flags", AT(hd_object_flags, value), 4, {0, 7}, {8, 0xffffffff}},
      {"flags", AT(hd_object_flags, reserved), 4, {0}, {1}},
      {"vertices", AT(hd_object_vertices, count), 4, {1, HD_VERTEX_MOVES}, {0, HD_VERTEX_MOVES + 1, 0xffffffff}},
      {"field", AT(hd_force_field, slot), 4, {0, HD_MODEL_SLOTS - 1}, bad_slot},
      {"field", AT(hd_force_field, device), 4, {0, kDevices - 1}, bad_device},
      {"field", AT(hd_force_field, reserved), 4, {0}, {1}},
      {"field", AT(hd_force_field, lease_ns), 8, good_lease, bad_lease},
      {"field", AT(hd_force_field, blend_ns), 8, good_blend, bad_blend},
      {"clear", AT(hd_clear_model, slot), 4, {0, HD_MODEL_SLOTS - 1}, bad_slot},
      {"clear", AT(hd_clear_model, reserved), 4, {0}, {1}},
      {"clear", AT(hd_clear_model, blend_ns), 8, good_blend, bad_blend},
      {"force", AT(hd_client_force, device), 4, {0, kDevices - 1}, bad_device},
      {"force", AT(hd_client_force, reserved), 4, {0}, {1}},
      {"force", AT(hd_client_force, lease_ns), 8, good_lease, bad_lease},
      {"intent", AT(hd_intent, device), 4, {0, kDevices - 1}, bad_device},
      {"intent", AT(hd_intent, reserved), 4, {0}, {1}},
      {"halfspaces", AT(hd_local_model, count), 4, {1, 2}, {0, 3, HD_HALFSPACES + 1, 0xffffffff}},  // the third is zero
      {"plane", AT(hd_local_model, kind), 4, {}, {0, HD_MODEL_SPHERE, HD_MODEL_HALFSPACES, 6, 0xffffffff}},
  };
  for (const char* model : {"plane", "spring", "sphere", "halfspaces", "corner"}) {
    all.push_back({model, AT(hd_local_model, slot), 4, {0, HD_MODEL_SLOTS - 1}, bad_slot});
    all.push_back({model, AT(hd_local_model, device), 4, {0, kDevices - 1}, bad_device});
    all.push_back({model, AT(hd_local_model, reserved), 4, {0}, {1}});
    all.push_back({model, AT(hd_local_model, lease_ns), 8, good_lease, bad_lease});
    all.push_back({model, AT(hd_local_model, blend_ns), 8, good_blend, bad_blend});
  }
  for (const Integer& field : all) {
    for (const Message& m : goodMessages()) {
      if (m.name != field.message) continue;
      const auto with = [&](std::int64_t value) {
        hd_slot slot = m.slot;
        std::memcpy(slot.payload + field.offset, &value, field.bytes);
        return check(slot);
      };
      const std::string where = m.name + " at " + std::to_string(field.offset);
      for (const auto value : field.good) EXPECT_EQ(with(value), ErrorCode::kOk) << where << ": " << value;
      for (const auto value : field.bad) EXPECT_EQ(with(value), ErrorCode::kInvalidArgument) << where << ": " << value;
    }
  }
}

TEST(Validate, NormalisesWhatIsNearlyUnit) {
  const auto scaled = [](double by) {
    hd_object_pose x = goodPose();
    for (double& q : x.q) q *= by;
    return x;
  };
  EXPECT_EQ(check(HD_COMMAND_OBJECT_POSE, scaled(1.0011)), ErrorCode::kInvalidArgument);
  EXPECT_EQ(check(HD_COMMAND_OBJECT_POSE, scaled(0.9989)), ErrorCode::kInvalidArgument);
  Command out;
  for (const double by : {1.0009, 0.9991, 1.0}) {
    ASSERT_EQ(validate(slotOf(HD_COMMAND_OBJECT_POSE, scaled(by)), 1, out), ErrorCode::kOk);
    const auto& q = out.as<hd_object_pose>().q;
    EXPECT_NEAR(q[0], 0.6, 1e-15);
    EXPECT_NEAR(q[2], 0.8, 1e-15);
  }
  hd_local_model patch = goodModel(HD_MODEL_HALFSPACES);
  for (int i = 0; i < 3; ++i) patch.halfspace[1][i] *= 1.0005f;
  ASSERT_EQ(validate(slotOf(HD_COMMAND_LOCAL_MODEL, patch), 1, out), ErrorCode::kOk);
  EXPECT_NEAR(out.as<hd_local_model>().halfspace[1][0], 0.6, 1e-7);
}

TEST(Validate, BoundsTheMagnitudeNotOnlyTheComponents) {
  hd_client_force x = goodForce();
  for (double& f : x.force) f = 0.6 * limits::kForce;  // |f| = 1.04 kForce
  EXPECT_EQ(check(HD_COMMAND_CLIENT_FORCE, x), ErrorCode::kInvalidArgument);
  store(Vec3(-limits::kForce, 0, 0), x.force);
  store(Vec3(0, limits::kTorque, 0), x.torque);
  EXPECT_EQ(check(HD_COMMAND_CLIENT_FORCE, x), ErrorCode::kOk) << "the most there is";
}

TEST(Validate, AModelMayHaveAsManyFacesAsFitAndNoMore) {
  hd_local_model x = goodModel(HD_MODEL_HALFSPACES);
  for (auto& face : x.halfspace) std::memcpy(face, x.halfspace[0], sizeof face);
  x.count = HD_HALFSPACES;
  EXPECT_EQ(check(HD_COMMAND_LOCAL_MODEL, x), ErrorCode::kOk);
  x.count = HD_HALFSPACES + 1;
  EXPECT_EQ(check(HD_COMMAND_LOCAL_MODEL, x), ErrorCode::kInvalidArgument);
}

// A number the servo does not expect may not reach it, so unused fields are cleared, not refused.
TEST(Validate, ClearsWhatTheKindOfModelDoesNotUse) {
  for (const auto kind : {HD_MODEL_PLANE, HD_MODEL_SPRING, HD_MODEL_SPHERE, HD_MODEL_HALFSPACES, HD_MODEL_CORNER}) {
    const hd_local_model good = goodModel(kind);
    hd_local_model x = good;
    if (kind != HD_MODEL_PLANE) x.normal[1] = kNan;
    const bool faces = kind == HD_MODEL_HALFSPACES || kind == HD_MODEL_CORNER;
    if (kind == HD_MODEL_PLANE || kind == HD_MODEL_CORNER) x.radius = kInf;
    if (!faces) x.count = 99;
    x.halfspace[5][2] = std::numeric_limits<float>::quiet_NaN();
    Command out;
    ASSERT_EQ(validate(slotOf(HD_COMMAND_LOCAL_MODEL, x), 1, out), ErrorCode::kOk) << kind;
    EXPECT_EQ(std::memcmp(&out.as<hd_local_model>(), &good, sizeof good), 0) << kind;
  }
  hd_object_vertices moves = goodVertices();
  moves.move[3].p[0] = std::numeric_limits<float>::quiet_NaN();
  Command out;
  ASSERT_EQ(validate(slotOf(HD_COMMAND_OBJECT_VERTICES, moves), 1, out), ErrorCode::kOk);
  EXPECT_EQ(out.as<hd_object_vertices>().move[3].p[0], 0.f);
}

TEST(Validate, VerticesMayEndAfterTheLastOneInUse) {
  hd_slot slot = slotOf(HD_COMMAND_OBJECT_VERTICES, goodVertices());
  slot.length = offsetof(hd_object_vertices, move) + 3 * sizeof(hd_vertex_move);
  EXPECT_EQ(check(slot), ErrorCode::kOk);
  slot.length -= 1;
  EXPECT_EQ(check(slot), ErrorCode::kInvalidArgument);
}

// Bytes of the copy beyond the stated length are those of an earlier message; they may not leak into this one.
TEST(Validate, IgnoresBytesBeyondTheLength) {
  hd_slot slot = slotOf(HD_COMMAND_LIMITS, goodLimits());
  std::memset(slot.payload + slot.length, 0xff, sizeof slot.payload - slot.length);
  Command out;
  std::memset(out.payload, 0xff, sizeof out.payload);
  ASSERT_EQ(validate(slot, 1, out), ErrorCode::kOk);
  for (std::size_t i = slot.length; i < sizeof out.payload; ++i) ASSERT_EQ(out.payload[i], 0) << i;
}

}  // namespace
}  // namespace hapticd
