// Intended motions: their geometry, their velocities, their published properties.
#include "drivers/sim/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/sim/body.h"

namespace hapticd {
namespace {

MotionParameters of(MotionKind kind) {
  MotionParameters m;
  m.kind = kind;
  m.centre = Vec3(0.01, -0.02, 0.03);
  m.sway = Vec3(0.2, 0.1, -0.3);
  m.orientation = Vec3(0.5, 0, 0.1);
  m.normal = Vec3(0.3, -0.4, 0.8);
  m.phase = Vec3(0.1, 0.2, 0.3);
  m.amplitude = Vec3(0.02, 0.03, 0.01);
  m.tremor = 1e-4;
  return m;
}

TEST(Motion, NamesAndKindsAgree) {
  EXPECT_EQ(motionKind("live"), MotionKind::kLive);
  EXPECT_EQ(motionKind("hold"), MotionKind::kHold);
  EXPECT_EQ(motionKind("tap"), MotionKind::kTap);
  EXPECT_EQ(motionKind("stroke"), MotionKind::kStroke);
  EXPECT_EQ(motionKind("circle"), MotionKind::kCircle);
  EXPECT_EQ(motionKind("lissajous"), MotionKind::kLissajous);
  EXPECT_EQ(motionKind("minjerk"), MotionKind::kMinJerk);
  EXPECT_EQ(motionKind("csv"), MotionKind::kCsv);
}

TEST(Motion, VelocitiesAreTheDerivatives) {
  for (const MotionKind kind : {MotionKind::kHold, MotionKind::kTap, MotionKind::kStroke, MotionKind::kCircle,
                                MotionKind::kLissajous, MotionKind::kMinJerk}) {
    const IntendedMotion motion(of(kind));
    const double d = 1e-6;
    for (double t = 0.0123; t < 6; t += 0.0317) {
      const PoseOnTrack a = motion.at(t - d), b = motion.at(t + d), now = motion.at(t);
      EXPECT_LT(((b.p - a.p) / (2 * d) - now.v).norm(), 1e-6) << static_cast<int>(kind) << " at " << t;
      EXPECT_LT((rotationVector(b.q * a.q.conjugate()) / (2 * d) - now.w).norm(), 1e-6) << static_cast<int>(kind);
    }
  }
}

TEST(Motion, CircleKeepsItsRadiusPlaneAndSense) {
  MotionParameters m = of(MotionKind::kCircle);
  m.tremor = 0;
  const IntendedMotion motion(m);
  const Vec3 n = m.normal.normalized();
  for (double t = 0; t < 2; t += 0.05) {
    const PoseOnTrack pose = motion.at(t);
    EXPECT_NEAR((pose.p - m.centre).norm(), m.radius, 1e-15);
    EXPECT_NEAR((pose.p - m.centre).dot(n), 0, 1e-15);
    EXPECT_GT((pose.p - m.centre).cross(pose.v).dot(n), 0);
  }
  m.normal = Vec3::UnitZ();
  EXPECT_LT((IntendedMotion(m).at(0).p - m.centre - Vec3(m.radius, 0, 0)).norm(), 1e-15);
}

TEST(Motion, TapRestsThenDipsToItsDepth) {
  MotionParameters m = of(MotionKind::kTap);
  m.tremor = 0;
  m.direction = Vec3(0, 0, -5);
  const IntendedMotion motion(m);
  for (double t = 0; t < 1; t += 0.1) EXPECT_EQ(motion.at(t).p, m.centre);
  EXPECT_LT((motion.at(1.5).p - m.centre - Vec3(0, 0, -m.depth)).norm(), 1e-15);
  EXPECT_LT((motion.at(2.5).p - m.centre).norm(), 1e-12);
}

TEST(Motion, StrokeGoesToAndFro) {
  MotionParameters m = of(MotionKind::kStroke);
  m.tremor = 0;
  const IntendedMotion motion(m);
  EXPECT_LT((motion.at(0).p - m.from).norm(), 1e-15);
  EXPECT_LT((motion.at(1).p - m.to).norm(), 1e-15);
  EXPECT_LT((motion.at(2).p - m.from).norm(), 1e-15);
}

TEST(Motion, MinimumJerkHasItsPublishedShape) {
  // Flash and Hogan 1985: rest at both ends, peak speed 1.875 times the mean, at the middle.
  MotionParameters m = of(MotionKind::kMinJerk);
  m.tremor = 0;
  const IntendedMotion motion(m);
  for (int stroke = 0; stroke < 20; ++stroke) {
    const double t0 = stroke * m.period;
    const PoseOnTrack start = motion.at(t0), end = motion.at(t0 + m.period * (1 - 1e-12));
    EXPECT_LT(start.v.norm(), 1e-12);
    EXPECT_LT(end.v.norm(), 1e-12);
    EXPECT_LT((motion.at(t0 + m.period).p - end.p).norm(), 1e-12) << "strokes join";
    const double mean = (end.p - start.p).norm() / m.period;
    EXPECT_NEAR(motion.at(t0 + m.period / 2).v.norm(), 1.875 * mean, 1e-9);
    for (int i = 0; i < 3; ++i) {
      EXPECT_GE(start.p[i], m.box_lower[i]);
      EXPECT_LE(start.p[i], m.box_upper[i]);
    }
  }
}

TEST(Motion, SeedsDifferAndRepeat) {
  MotionParameters m = of(MotionKind::kMinJerk);
  const IntendedMotion a(m), again(m);
  m.seed = 2;
  const IntendedMotion other(m);
  double apart = 0;
  for (double t = 0; t < 20; t += 0.1) {
    EXPECT_EQ(a.at(t).p, again.at(t).p);
    apart = std::max(apart, (a.at(t).p - other.at(t).p).norm());
  }
  EXPECT_GT(apart, 0.01);
}

TEST(Motion, TargetsFillTheBoxEvenly) {
  MotionParameters m = of(MotionKind::kMinJerk);
  m.tremor = 0;
  const IntendedMotion motion(m);
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    const Vec3 p = motion.at(i * m.period).p / 0.03;  // Each component uniform in [-1, 1].
    sum += p;
    squares += p.cwiseProduct(p);
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(sum[i] / n, 0, 5 * std::sqrt(1.0 / 3 / n));
    EXPECT_NEAR(squares[i] / n, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / n));
  }
}

/** Share of the power of x, sampled every `step`, that lies in [low, high] Hz. */
double powerShare(const std::vector<double>& x, double step, double low, double high) {
  const auto n = static_cast<double>(x.size());
  double inside = 0, total = 0;
  for (int k = 1; k < static_cast<int>(x.size()) / 2; ++k) {
    double re = 0, im = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double turn = 2 * EIGEN_PI * static_cast<double>(i) / n;
      const double windowed = x[i] * 0.5 * (1 - std::cos(turn));  // Hann: the tones do not leak out of the band.
      re += windowed * std::cos(turn * k);
      im += windowed * std::sin(turn * k);
    }
    const double hz = k / (n * step);
    total += re * re + im * im;
    if (hz >= low && hz <= high) inside += re * re + im * im;
  }
  return inside / total;
}

TEST(Motion, TremorLiesBetweenEightAndTwelveHertz) {
  MotionParameters m;
  m.kind = MotionKind::kHold;
  m.tremor = 1e-4;
  for (m.seed = 1; m.seed <= 5; ++m.seed) {
    const IntendedMotion motion(m);
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> x;
      for (int i = 0; i < 400; ++i) x.push_back(motion.at(i / 80.0).p[axis]);
      EXPECT_GT(powerShare(x, 1 / 80.0, 7.5, 12.5), 0.99) << m.seed << " " << axis;
    }
  }
}

TEST(Motion, WaitsAtItsFirstPose) {
  MotionParameters m = of(MotionKind::kCircle);
  m.tremor = 0;
  m.wait = 1.5;
  const IntendedMotion waiting(m);
  m.wait = 0;
  const IntendedMotion running(m);
  EXPECT_EQ(waiting.at(1.4).p, running.at(0).p);
  EXPECT_EQ(waiting.at(1.4).v, Vec3(Vec3::Zero()));
  EXPECT_LT((waiting.at(1.75).p - running.at(0.25).p).norm(), 1e-12);
}

TEST(Motion, ARecordingStandsWhileItWaits) {
  MotionParameters m = of(MotionKind::kCsv);
  m.track = *parsePoseCsv("0,0.01,0,0,1,0,0,0\n1,0.11,0,0,0,0,0,1\n", "test.csv");
  m.wait = 1.5;
  for (const bool loop : {false, true}) {
    m.loop = loop;
    const IntendedMotion waiting(m);
    for (const double t_s : {0.0, 0.7, 1.4999}) {
      const PoseOnTrack pose = waiting.at(t_s);
      EXPECT_EQ(pose.p, Vec3(0.01, 0, 0)) << t_s;
      EXPECT_EQ(pose.v, Vec3(Vec3::Zero())) << "else the hand is pulled away from where it waits, " << t_s;
      EXPECT_EQ(pose.w, Vec3(Vec3::Zero())) << t_s;
    }
    EXPECT_NEAR(waiting.at(1.75).p.x(), 0.035, 1e-12);
    EXPECT_NEAR(waiting.at(1.75).v.x(), 0.1, 1e-12);
  }
}

TEST(Motion, LissajousSwingsAlongEachAxisByItself) {
  MotionParameters m = of(MotionKind::kLissajous);
  m.tremor = 0;
  m.ratio = Vec3(1, 2, 3);
  const IntendedMotion motion(m);
  for (const double t_s : {0.0, 0.3, 1.1}) {
    const double angle = 2 * std::numbers::pi * t_s / m.period;
    Vec3 place = m.centre;
    for (int i = 0; i < 3; ++i) place[i] += m.amplitude[i] * std::sin(m.ratio[i] * angle + m.phase[i]);
    EXPECT_LT((motion.at(t_s).p - place).norm(), 1e-12) << t_s;
  }
}

TEST(Motion, OnlyLiveListens) {
  DeviceIntent intent;
  intent.p = Vec3(0.1, 0.1, 0.1);
  for (const MotionKind kind : {MotionKind::kHold, MotionKind::kCircle}) {
    IntendedMotion motion(of(kind));
    const Vec3 before = motion.at(0.3).p;
    motion.setLive(intent);
    EXPECT_EQ(motion.at(0.3).p, before);
  }
}

TEST(Motion, ALiveHandStrivesNoFartherThanItSaysButThatFar) {
  IntendedMotion motion(of(MotionKind::kLive));
  DeviceIntent intent;
  intent.p = Vec3(0.1, -99, 1e300);
  motion.setLive(intent);
  EXPECT_EQ(motion.at(0.3).p, Vec3(0.1, -10, 10));
  intent.p.x() = std::numeric_limits<double>::quiet_NaN();
  motion.setLive(intent);
  EXPECT_EQ(motion.at(0.3).p, Vec3(0.1, -10, 10)) << "what is no place is passed over";
}

TEST(Motion, ALiveHandStartsWhereItIsSetUpAndTurnsAsItIsTold) {
  MotionParameters set_up = of(MotionKind::kLive);
  set_up.gripper_angle = 0.3;
  IntendedMotion motion(set_up);
  EXPECT_EQ(motion.at(0.3).p, set_up.centre);
  EXPECT_LT(motion.at(0.3).q.angularDistance(fromRotationVector(set_up.orientation)), 1e-12);
  EXPECT_EQ(motion.at(0.3).gripper_rad, 0.3);
  const Quat told = fromRotationVector(Vec3(0.2, 0.4, -0.7));
  DeviceIntent intent;
  for (const double length : {0.52, 1.0, 1.98}) {  // What still means a rotation is taken as one.
    for (const double angle : {-10.0, 0.1, 10.0}) {
      intent.q.coeffs() = length * told.coeffs();
      intent.gripper_rad = angle;
      motion.setLive(intent);
      EXPECT_LT((motion.at(0.3).q.coeffs() - told.coeffs()).norm(), 1e-12) << length;
      EXPECT_EQ(motion.at(0.3).gripper_rad, angle);
    }
  }
  const PoseOnTrack before = motion.at(0.3);
  intent.q = Quat::Identity();
  for (const double angle : {-10.1, 10.1, std::numeric_limits<double>::quiet_NaN()}) {
    intent.gripper_rad = angle;
    motion.setLive(intent);
  }
  intent.gripper_rad = 0;
  for (const double length : {0.0, 0.48, 2.02, std::numeric_limits<double>::infinity()}) {
    intent.q.coeffs() = length * told.coeffs();
    motion.setLive(intent);
  }
  EXPECT_EQ(motion.at(0.3).q.coeffs(), before.q.coeffs());
  EXPECT_EQ(motion.at(0.3).gripper_rad, before.gripper_rad);
}

}  // namespace
}  // namespace hapticd
