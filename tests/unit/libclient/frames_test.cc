// Every axis is checked by what it means to the operator, so that the table of the header is the oracle.
#include <gtest/gtest.h>
#include <hapticclient/frames.h>

#include <array>
#include <cmath>

namespace {

using Vector = std::array<double, 3>;
constexpr haptic_frame kAll[] = {HAPTIC_FRAME_HAPTICD, HAPTIC_FRAME_OPENGL, HAPTIC_FRAME_ROS, HAPTIC_FRAME_HAPLY};

Vector convert(haptic_frame from, haptic_frame to, Vector v) {
  EXPECT_EQ(haptic_convert_vector(from, to, v.data(), v.data()), HAPTIC_OK);
  return v;
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector rotate(const std::array<double, 4>& q, const Vector& v) {
  const Vector u = {q[1], q[2], q[3]};
  const Vector uv = cross(u, v);
  const Vector uuv = cross(u, uv);
  Vector r;
  for (int i = 0; i < 3; ++i) r[i] = v[i] + 2 * (q[0] * uv[i] + uuv[i]);
  return r;
}

TEST(Frames, EachAxisPointsWhereTheTableSays) {
  struct Row {
    haptic_frame frame;
    Vector toward, right, up;
  };
  const Row rows[] = {{HAPTIC_FRAME_HAPTICD, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                      {HAPTIC_FRAME_OPENGL, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
                      {HAPTIC_FRAME_ROS, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
                      {HAPTIC_FRAME_HAPLY, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
  for (const Row& row : rows) {
    EXPECT_EQ(convert(HAPTIC_FRAME_HAPTICD, row.frame, {1, 0, 0}), row.toward) << row.frame;
    EXPECT_EQ(convert(HAPTIC_FRAME_HAPTICD, row.frame, {0, 1, 0}), row.right) << row.frame;
    EXPECT_EQ(convert(HAPTIC_FRAME_HAPTICD, row.frame, {0, 0, 1}), row.up) << row.frame;
  }
}

TEST(Frames, RightHandedBetweenAllPairsAndExactThereAndBack) {
  const Vector v = {0.1, -2e-7, 3.3};
  for (const haptic_frame a : kAll) {
    for (const haptic_frame b : kAll) {
      const Vector x = convert(a, b, {1, 0, 0});
      const Vector y = convert(a, b, {0, 1, 0});
      EXPECT_EQ(cross(x, y), convert(a, b, {0, 0, 1})) << a << " to " << b;
      EXPECT_EQ(convert(b, a, convert(a, b, v)), v) << a << " to " << b;
    }
  }
}

TEST(Frames, AQuaternionTurnsTheSameThingsInEveryFrame) {
  const std::array<double, 4> q = {0.5, -0.1, 0.7, std::sqrt(1 - 0.25 - 0.01 - 0.49)};
  const Vector v = {0.3, -0.4, 0.9};
  for (const haptic_frame a : kAll) {
    for (const haptic_frame b : kAll) {
      std::array<double, 4> turned;
      ASSERT_EQ(haptic_convert_quaternion(a, b, q.data(), turned.data()), HAPTIC_OK);
      const Vector there = rotate(turned, convert(a, b, v));
      const Vector want = convert(a, b, rotate(q, v));
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(there[i], want[i], 1e-15) << a << " to " << b;
    }
  }
}

TEST(Frames, AMatrixMapsTheSameThingsInEveryFrame) {
  const double m[9] = {1, 2, 3, 4, 5, 6, 7, 8, 10};
  const Vector v = {0.25, -0.5, 2};
  const auto apply = [](const double* a, const Vector& x) {
    Vector r;
    for (int i = 0; i < 3; ++i) r[i] = a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2];
    return r;
  };
  for (const haptic_frame a : kAll) {
    for (const haptic_frame b : kAll) {
      double turned[9];
      ASSERT_EQ(haptic_convert_matrix(a, b, m, turned), HAPTIC_OK);
      EXPECT_EQ(apply(turned, convert(a, b, v)), convert(a, b, apply(m, v))) << a << " to " << b;
    }
  }
}

TEST(Frames, RefusesUnknownFramesAndNoPlace) {
  double v[3] = {1, 2, 3};
  EXPECT_EQ(haptic_convert_vector(4, HAPTIC_FRAME_ROS, v, v), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_convert_vector(HAPTIC_FRAME_ROS, 4, v, v), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(v[0], 1);
  double m[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_EQ(haptic_convert_quaternion(HAPTIC_FRAME_ROS, 4, m, m), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_convert_matrix(HAPTIC_FRAME_ROS, 4, m, m), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(m[0], 1);
  for (const auto convert : {haptic_convert_vector, haptic_convert_quaternion, haptic_convert_matrix}) {
    EXPECT_EQ(convert(HAPTIC_FRAME_ROS, HAPTIC_FRAME_OPENGL, nullptr, m), HAPTIC_INVALID_ARGUMENT);
    EXPECT_EQ(convert(HAPTIC_FRAME_ROS, HAPTIC_FRAME_OPENGL, m, nullptr), HAPTIC_INVALID_ARGUMENT);
  }
}

}  // namespace
