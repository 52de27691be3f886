#include <hapticclient/frames.h>

#include <array>
#include <cstdint>

namespace {

/** One axis of a frame, in hapticd's axes. */
struct Axis {
  int index;
  double sign;
};
using Frame = std::array<Axis, 3>;

// From the table in frames.h: where each frame's x, y and z point, in hapticd's axes
// (0: toward the operator, 1: the operator's right, 2: up).
constexpr std::array<Frame, 4> kFrames = {{
    {{{0, 1}, {1, 1}, {2, 1}}},    // hapticd
    {{{1, 1}, {2, 1}, {0, 1}}},    // OpenGL: x right, y up, z toward the operator
    {{{0, -1}, {1, -1}, {2, 1}}},  // ROS: x away from the operator, y left, z up
    {{{1, 1}, {0, -1}, {2, 1}}},   // Haply: x right, y away from the operator, z up
}};

const Frame* frameOf(std::uint32_t frame) { return frame < kFrames.size() ? &kFrames[frame] : nullptr; }

/** 0 - 0 would give a -0 that no input had; adding a positive zero makes both zeros positive. */
double exact(double value, double sign) { return value * sign + 0.0; }

}  // namespace

extern "C" {

int haptic_convert_vector(uint32_t from, uint32_t to, const double in[3], double out[3]) {
  const Frame* source = frameOf(from);
  const Frame* target = frameOf(to);
  if (source == nullptr || target == nullptr || in == nullptr || out == nullptr) return HAPTIC_INVALID_ARGUMENT;
  double own[3];
  for (int i = 0; i < 3; ++i) own[(*source)[i].index] = exact(in[i], (*source)[i].sign);
  for (int i = 0; i < 3; ++i) out[i] = exact(own[(*target)[i].index], (*target)[i].sign);
  return HAPTIC_OK;
}

int haptic_convert_quaternion(uint32_t from, uint32_t to, const double in[4], double out[4]) {
  // M R M^T for a proper M turns the axis of R by M and keeps its angle.
  if (in == nullptr || out == nullptr) return HAPTIC_INVALID_ARGUMENT;
  const double w = in[0];
  const int code = haptic_convert_vector(from, to, in + 1, out + 1);
  if (code == HAPTIC_OK) out[0] = w;
  return code;
}

int haptic_convert_matrix(uint32_t from, uint32_t to, const double in[9], double out[9]) {
  if (in == nullptr || out == nullptr) return HAPTIC_INVALID_ARGUMENT;
  double rows[9];
  for (int i = 0; i < 3; ++i) {
    if (const int code = haptic_convert_vector(from, to, in + 3 * i, rows + 3 * i); code != HAPTIC_OK) return code;
  }
  for (int j = 0; j < 3; ++j) {
    const double column[3] = {rows[j], rows[3 + j], rows[6 + j]};
    double turned[3];
    haptic_convert_vector(from, to, column, turned);
    for (int i = 0; i < 3; ++i) out[3 * i + j] = turned[i];
  }
  return HAPTIC_OK;
}

}  // extern "C"
