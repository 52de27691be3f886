#include "tools/hapticctl-import/image.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace hapticctl_import {
namespace {

std::size_t indexOf(const Image& image, std::size_t x, std::size_t y, std::size_t z) {
  return x + image.size[0] * (y + image.size[1] * z);
}

/** Convolves with a Gaussian along one axis. */
void smoothAlong(Image& image, std::size_t axis, double sigma_mm) {
  const std::size_t stride[3] = {1, image.size[0], std::size_t{image.size[0]} * image.size[1]};
  const double sigma = sigma_mm / spacing(image, axis);
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3 * sigma));
  if (reach == 0) return;
  std::vector<double> weight;
  double sum = 0;
  for (std::ptrdiff_t i = -reach; i <= reach; ++i) {
    const double deviations = static_cast<double>(i) / sigma;  // The square of a tiny sigma is 0.
    weight.push_back(std::exp(-0.5 * deviations * deviations));
    sum += weight.back();
  }
  const auto n = static_cast<std::ptrdiff_t>(image.size[axis]);
  std::vector<float> line(image.size[axis]);
  for (std::size_t start = 0; start < image.values.size(); ++start) {
    if (start / stride[axis] % image.size[axis] != 0) continue;  // Not the first of its line.
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      double mean = 0;
      for (std::ptrdiff_t j = -reach; j <= reach; ++j) {
        const auto from = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i + j, 0, n - 1));
        mean += weight[static_cast<std::size_t>(j + reach)] *
                static_cast<double>(image.values[start + stride[axis] * from]);
      }
      line[static_cast<std::size_t>(i)] = static_cast<float>(mean / sum);
    }
    for (std::size_t i = 0; i < line.size(); ++i) image.values[start + stride[axis] * i] = line[i];
  }
}

}  // namespace

void requireTwo(const Image& image, const char* where) {
  if (std::all_of(image.size.begin(), image.size.end(), [](std::uint32_t n) { return n >= 2; })) return;
  if (std::string(where).rfind("--", 0) == 0)
    throw ImportError(where, "fewer than two values are left along an axis", "leave more of the image");
  throw ImportError(where, "there is one value along an axis: a single slice", "import all slices together");
}

double cellVolume(const Image& image) {
  const auto& s = image.step;
  return s[0][0] * (s[1][1] * s[2][2] - s[1][2] * s[2][1]) - s[0][1] * (s[1][0] * s[2][2] - s[1][2] * s[2][0]) +
         s[0][2] * (s[1][0] * s[2][1] - s[1][1] * s[2][0]);
}

void checkPlace(const Image& image) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (!std::isfinite(image.origin[k]) || !(spacing(image, k) > 1e-6 && spacing(image, k) < 1e6))
      throw ImportError("spacing", "is not a length, or the origin no place", "correct the header");
  }
  if (!(std::abs(cellVolume(image)) > 1e-6 * spacing(image, 0) * spacing(image, 1) * spacing(image, 2)))
    throw ImportError("orientation", "the axes lie in one plane", "correct the header");
  constexpr double kFarthest = 1e6;  // Steps: vertices are floats, here a sixteenth of one apart.
  const double least = std::min({spacing(image, 0), spacing(image, 1), spacing(image, 2)});
  for (const double x : image.origin) {
    const double far = std::abs(x);
    if (far <= kFarthest * least) continue;
    throw ImportError(
        "origin", fmt::format("is {:.4g} mm away, for values {:.4g} mm apart too far to tell them apart", far, least),
        "move it nearer in the header");
  }
}

double spacing(const Image& image, std::size_t axis) {
  const Double3& s = image.step[axis];
  return std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
}

Image crop(const Image& image, const std::array<std::uint32_t, 3>& first, const std::array<std::uint32_t, 3>& end) {
  Image out;
  out.format = image.format;
  out.step = image.step;
  out.origin = image.origin;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t last = std::min(end[k], image.size[k]);
    out.size[k] = last > first[k] ? last - first[k] : 0;
    for (std::size_t a = 0; a < 3; ++a) out.origin[a] += image.step[k][a] * first[k];
  }
  requireTwo(out, "--crop");
  out.values.reserve(std::size_t{out.size[0]} * out.size[1] * out.size[2]);
  for (std::size_t z = 0; z < out.size[2]; ++z) {
    for (std::size_t y = 0; y < out.size[1]; ++y) {
      const auto row =
          image.values.begin() + static_cast<std::ptrdiff_t>(indexOf(image, first[0], y + first[1], z + first[2]));
      out.values.insert(out.values.end(), row, row + out.size[0]);
    }
  }
  return out;
}

Image shrink(const Image& image, std::uint32_t n) {
  Image out;
  out.format = image.format;
  out.origin = image.origin;
  for (std::size_t k = 0; k < 3; ++k) {
    out.size[k] = image.size[k] / n;
    for (std::size_t a = 0; a < 3; ++a) {
      out.step[k][a] = image.step[k][a] * n;
      out.origin[a] += image.step[k][a] * (n - 1) / 2.0;  // A block's mean stands in its middle.
    }
  }
  requireTwo(out, "--shrink");
  out.values.assign(std::size_t{out.size[0]} * out.size[1] * out.size[2], 0);
  const double share = 1.0 / (static_cast<double>(n) * n * n);
  for (std::size_t z = 0; z < out.size[2]; ++z) {
    for (std::size_t y = 0; y < out.size[1]; ++y) {
      for (std::size_t x = 0; x < out.size[0]; ++x) {
        double sum = 0;
        for (std::size_t c = 0; c < n; ++c) {
          for (std::size_t b = 0; b < n; ++b)
            for (std::size_t a = 0; a < n; ++a) sum += image.values[indexOf(image, x * n + a, y * n + b, z * n + c)];
        }
        out.values[indexOf(out, x, y, z)] = static_cast<float>(sum * share);
      }
    }
  }
  return out;
}

Image resample(Image image, double spacing_mm) {
  Image out;
  out.format = image.format;
  out.origin = image.origin;
  std::array<double, 3> first{}, each{};
  double count = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const double before = spacing(image, k), extent = (image.size[k] - 1) * before;
    const double steps = std::floor(extent / spacing_mm * (1 + 1e-9));
    count *= steps + 1;
    if (!(count <= 2147483648.0)) throw ImportError("--resample", "more than 2^31 values", "choose a larger distance");
    out.size[k] = static_cast<std::uint32_t>(steps) + 1;
    each[k] = spacing_mm / before;
    first[k] = (extent - steps * spacing_mm) / 2 / before;
    for (std::size_t a = 0; a < 3; ++a) {
      out.step[k][a] = image.step[k][a] * each[k];
      out.origin[a] += image.step[k][a] * first[k];
    }
    // Then its deviation is half the new step, all in all, if the old values are taken for half the old one.
    if (spacing_mm > before) smoothAlong(image, k, std::sqrt(spacing_mm * spacing_mm - before * before) / 2);
  }
  requireTwo(out, "--resample");
  out.values.reserve(std::size_t{out.size[0]} * out.size[1] * out.size[2]);
  std::array<std::size_t, 3> i{};
  const auto cellAt = [&](std::size_t axis, double& share) {
    const double at = std::clamp(first[axis] + static_cast<double>(i[axis]) * each[axis], 0.0, image.size[axis] - 1.0);
    const double cell = std::min(std::floor(at), image.size[axis] - 2.0);
    share = at - cell;
    return static_cast<std::size_t>(cell);
  };
  for (i[2] = 0; i[2] < out.size[2]; ++i[2]) {
    for (i[1] = 0; i[1] < out.size[1]; ++i[1]) {
      for (i[0] = 0; i[0] < out.size[0]; ++i[0]) {
        double u = 0, v = 0, w = 0, sum = 0;
        const std::size_t x = cellAt(0, u), y = cellAt(1, v), z = cellAt(2, w);
        for (std::size_t c = 0; c < 8; ++c) {
          const std::size_t a = c & 1, b = c >> 1 & 1, d = c >> 2;
          sum += (a != 0 ? u : 1 - u) * (b != 0 ? v : 1 - v) * (d != 0 ? w : 1 - w) *
                 static_cast<double>(image.values[indexOf(image, x + a, y + b, z + d)]);
        }
        out.values.push_back(static_cast<float>(sum));
      }
    }
  }
  return out;
}

void smooth(Image& image, double sigma_mm) {
  for (std::size_t axis = 0; axis < 3; ++axis) smoothAlong(image, axis, sigma_mm);
}

void chooseLabel(Image& image, double label) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    float& v = image.values[i];
    v = (image.exact.empty() ? v == static_cast<float>(label) : image.exact[i] == label) ? 1.0f : 0.0f;
  }
  image.exact = {};
}

}  // namespace hapticctl_import
