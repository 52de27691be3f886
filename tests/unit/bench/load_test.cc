// Local models against the native scene, stepped: what a good client at 30 Hz and 5 ms late must reach, and that the
// yardsticks agree with closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/load/built_surface.h"
#include "tools/haptic-bench/load/judge.h"
#include "tools/haptic-bench/load/levels.h"
#include "tools/haptic-bench/load/stepped.h"

namespace haptic_bench {
namespace {

using ::testing::ThrowsMessage;

constexpr double kSeconds = 1;
constexpr ClientTiming kSlow{1.0 / 30, 0.005, 1000};

std::span<const Vec3> settled(const std::vector<Vec3>& forces) { return std::span(forces).subspan(kSettled); }

/** The sphere of 50 mm radius and 16 k triangles. */
const BuiltSurface& ball() {
  static const BuiltSurface surface(tessellate({}, 16128));
  return surface;
}

TEST(Load, StrokeKeepsSpeedAndDepth) {
  const Stroked s = strokeOver({0.05, 0}, {}, kSeconds);
  ASSERT_EQ(s.hips.size(), kApproach + 1000);
  for (std::size_t i = kApproach + 1; i < s.hips.size(); ++i) {
    ASSERT_NEAR(s.hips[i].norm(), 0.049, 1e-12);
    ASSERT_NEAR((s.hips[i] - s.hips[i - 1]).norm(), 1e-4 * 0.049 / 0.05, 1e-9);
    ASSERT_LT((s.forces[i] - s.hips[i].normalized()).norm(), 1e-6);
  }
}

TEST(Load, BumpsHaveTheirHeightAndTheirNormals) {
  const BumpySphere statue{0.05, 0.3};
  double low = 1, high = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 u = Vec3(std::sin(1.3 * i), std::sin(2.1 * i + 1), std::sin(0.7 * i + 2)).normalized();
    const Vec3 n = statue.normal(u), p = statue.point(3 * u);
    ASSERT_NEAR(n.norm(), 1, 1e-12);
    ASSERT_GT(n.dot(u), 0.1) << "outward";
    ASSERT_LT((p.normalized() - u).norm(), 1e-12) << "above the direction, however long";
    for (int k = 0; k < 8; ++k) {  // Chords through the point are flat to first order.
      const Vec3 side = 1e-4 * Vec3(std::cos(k), std::sin(k), std::cos(2.0 * k));
      const Vec3 chord = statue.point(u + side) - statue.point(u - side);
      ASSERT_LT(std::abs(n.dot(chord)), 1e-3 * chord.norm() + 1e-10) << i;
    }
    low = std::min(low, p.norm()), high = std::max(high, p.norm());
  }
  EXPECT_LT(low, 0.05 * 0.8);
  EXPECT_GE(low, 0.05 * 0.7);
  EXPECT_GT(high, 0.05 * 1.2);
  EXPECT_LE(high, 0.05 * 1.3);
}

TEST(Load, TheDisksLoadIsNotInMemory) {
  EXPECT_EQ(folderOnDisk("/dev/shm"), "/var/tmp");
  EXPECT_EQ(folderOnDisk("/proc"), "/proc") << "no memory, and it says itself that it cannot be";
}

TEST(Load, ItsDaemonIsToldNothingOfTheUsersOwn) {
  const ScratchDirectory folder;
  const std::string log = folder.path() + "/log";
  constexpr const char* kNames[] = {"HAPTICD_SOCKET", "HAPTICD_CONFIG", "LISTEN_FDS", "LISTEN_PID", "NOTIFY_SOCKET"};
  for (const char* name : kNames) setenv(name, "the user's", 1);
  for (const char* program : {"/usr/bin/env", "/none"}) {
    Child child({program}, log);
    while (child.running()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  for (const char* name : kNames) unsetenv(name);
  std::string said;
  std::getline(std::ifstream(log), said, '\0');
  EXPECT_THAT(said, ::testing::HasSubstr("PATH="));
  EXPECT_THAT(said, ::testing::HasSubstr("/none: No such file")) << "behind what was there";
  EXPECT_THAT(said, ::testing::Not(::testing::HasSubstr("the user's")));
}

TEST(Load, AFolderInWhichNothingCanBeMadeIsToldAsWhatItIs) {
  testing::internal::CaptureStderr();
  {
    std::vector<Child> children = startLoad(Level::kDisk, "", "/proc/self");
    ASSERT_EQ(children.size(), 1u);
    while (children[0].running()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, ::testing::HasSubstr(std::string(": ") + std::strerror(ENOENT) + " (64 MB"));
}

TEST(Load, ErrorsOfKnownForces) {
  const std::vector<Vec3> reference(4, Vec3(2, 0, 0));
  const std::vector<Vec3> forces{{2, 0, 0}, {2, 0.2, 0}, {2, 0, 0.2}, {2, 0, 0}};
  const ForceError e = compareForces(forces, reference);
  EXPECT_NEAR(e.mean, 2, 1e-15);
  EXPECT_NEAR(e.max, 0.1, 1e-15);
  EXPECT_NEAR(e.rms, 0.1 / std::sqrt(2), 1e-15);
  EXPECT_NEAR(e.change_max, 0.1 * std::sqrt(2), 1e-15);
}

/** A hand at rest that high over the top of the ball; `owner` pushes it with so much. */
std::vector<haptic_sample> restingAt(double height, std::size_t owner, float force) {
  haptic_sample sample{};
  sample.p[2] = 0.05 + height;
  sample.by_source[owner][2] = force;
  return std::vector<haptic_sample>(200, sample);
}

TEST(Load, ARunThatTouchedNothingIsNoErrorOfNoNumber) {
  for (const Source source : {Source::kNative, Source::kPlane, Source::kForce}) {
    for (const auto& samples : {restingAt(0.001, HAPTIC_SOURCE_SURFACE, 0), std::vector<haptic_sample>()}) {
      EXPECT_THAT([&] { (void)judgeForces(samples, ball(), source, 1000); },
                  ThrowsMessage<Failure>("load: the hand touched nothing (a stroke takes 0.72 s: more --seconds)"))
          << "it was judged";
    }
  }
}

TEST(Load, ARunIsJudgedByTheShareOfItsSource) {
  const std::pair<Source, std::size_t> owners[] = {{Source::kNative, HAPTIC_SOURCE_SURFACE},
                                                   {Source::kPlane, HAPTIC_SOURCE_LOCAL_MODEL},
                                                   {Source::kPatch, HAPTIC_SOURCE_LOCAL_MODEL},
                                                   {Source::kForce, HAPTIC_SOURCE_CLIENT}};
  for (const auto& [source, owner] : owners) {
    const ForceError half = judgeForces(restingAt(-0.001, owner, 0.5F), ball(), source, 1000);
    EXPECT_NEAR(half.mean, 1, 0.01);
    EXPECT_NEAR(half.rms, 0.5, 0.01);
    const ForceError none = judgeForces(restingAt(-0.001, HAPTIC_SOURCE_EFFECT, 0.5F), ball(), source, 1000);
    EXPECT_NEAR(none.rms, 1, 1e-6) << "others' shares do not count";
  }
}

// The fit was for another time than the one at which the model came in.
TEST(Load, ALatencyIsOfWholeTicksAndOneAtLeast) {
  EXPECT_EQ(steppedLatency_s(0), 0.001);
  EXPECT_EQ(steppedLatency_s(0.0004), 0.001);
  EXPECT_DOUBLE_EQ(steppedLatency_s(0.0026), 0.003);
  const Stroked s = strokeOver({0.05, 0}, {}, 0.6);
  for (const Source source : {Source::kPlane, Source::kPatch, Source::kForce}) {
    const auto forces = [&](double latency_s) {
      return clientForces(source, ball().client(), {1.0 / 30, latency_s, 1000}, s.hips);
    };
    EXPECT_TRUE(forces(0) == forces(0.001)) << nameOf(source);
    EXPECT_TRUE(forces(0.0026) == forces(0.003)) << nameOf(source);
  }
}

TEST(Load, AForceIsThatOfWhereTheHandWasItsLatencyAgo) {
  const Stroked s = strokeOver({0.05, 0}, {.force = 0.5}, 0.3);
  const std::vector<Vec3> exact = nearestForces(ball().client(), 1000, s.hips);
  for (const std::size_t late : {1u, 3u, 12u}) {
    const ClientTiming timing{1e-3, 1e-3 * static_cast<double>(late), 1000};
    const std::vector<Vec3> forces = clientForces(Source::kForce, ball().client(), timing, s.hips);
    ASSERT_EQ(forces.size(), s.hips.size());
    for (std::size_t i = 0; i < forces.size(); ++i) {
      const Vec3 wanted = i < late ? Vec3(Vec3::Zero()) : exact[i - late];
      ASSERT_LT((forces[i] - wanted).norm(), 1e-9) << late << " " << i;
    }
  }
}

TEST(Load, AClientsOrdersOutliveTwoThatAreLost) {
  const Vec3 inside(0.003, 0.001, 0.049), outside(0.003, 0.001, 0.051);
  for (const auto& [rate_hz, lease_ns] : {std::pair{10.0, 300'000'000}, {1000.0, 50'000'000}}) {
    const ClientTiming timing{1 / rate_hz, 0.005, 700};
    EXPECT_EQ(fitForce(ball().client(), inside, timing).lease_ns, lease_ns);
    for (const Source source : {Source::kPlane, Source::kPatch}) {
      const haptic_local_model model = fitModel(source, ball().client(), inside, Vec3::Zero(), timing);
      EXPECT_EQ(model.lease_ns, lease_ns) << nameOf(source);
      EXPECT_EQ(model.material.stiffness, 700);
      EXPECT_EQ(model.blend_ns, source == Source::kPlane ? std::llround(1e9 / rate_hz) : 0) << nameOf(source);
    }
    const haptic_client_force order = fitForce(ball().client(), inside, timing);
    const auto& force = order.force;
    EXPECT_NEAR(std::hypot(force[0], force[1], force[2]), 700 * (0.05 - inside.norm()), 0.02);
    EXPECT_NEAR(force[0] / force[2], inside.x() / inside.z(), 0.02);
    EXPECT_EQ(fitForce(ball().client(), outside, timing).force[2], 0);
  }
}

TEST(Load, PatchAtThirtyHertzIsTheMesh) {
  const Stroked s = strokeOver({0.05, 0}, {}, kSeconds);
  const std::vector<Vec3> patch = clientForces(Source::kPatch, ball().client(), kSlow, s.hips);
  const ForceError off = compareForces(settled(patch), settled(nearestForces(ball().client(), 1000, s.hips)));
  EXPECT_NEAR(off.mean, 1, 0.05);
  EXPECT_LT(off.rms, 1e-4);
  EXPECT_LT(off.change_max, 0.01);
  EXPECT_LT(compareForces(settled(patch), settled(nativeForces(ball().meshes(), 1000, s.hips))).rms, 0.02);
}

TEST(Load, PlaneAtThirtyHertzIsNearTheSurface) {
  const Stroked s = strokeOver({0.05, 0}, {.stiffness = 300}, kSeconds);
  const ClientTiming timing{kSlow.period_s, kSlow.latency_s, 300};
  const std::vector<Vec3> plane = clientForces(Source::kPlane, ball().client(), timing, s.hips);
  EXPECT_LT(compareForces(settled(plane), settled(nativeForces(ball().meshes(), 300, s.hips))).rms, 0.1);
  EXPECT_LT(compareForces(settled(plane), settled(s.forces)).change_max, 0.01);
  // A plane knows of no faces, so it cannot step where the mesh steps: 1 % a tick holds against the shaded mesh alone.
  const std::vector<Vec3> shaded = nativeForces(ball().meshes(), 300, s.hips, Facets::kShaded);
  EXPECT_LT(compareForces(settled(plane), settled(shaded)).change_max, 0.01);
}

TEST(Load, AFasterClientComesIntoForceToo) {
  const Stroked s = strokeOver({0.05, 0}, {}, kSeconds);
  const ClientTiming timing{1e-3, 0.005, 1000};
  for (const Source source : {Source::kPlane, Source::kPatch, Source::kForce}) {
    const std::vector<Vec3> forces = clientForces(source, ball().client(), timing, s.hips);
    EXPECT_LT(compareForces(settled(forces), settled(s.forces)).rms, 0.05) << nameOf(source);
  }
}

}  // namespace
}  // namespace haptic_bench
