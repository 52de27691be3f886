#include "tools/hapticctl-import/image.h"

#include <algorithm>
#include <cmath>

namespace hapticctl_import {
namespace {

std::size_t indexOf(const Image& image, std::size_t x, std::size_t y, std::size_t z) {
  return x + image.size[0] * (y + image.size[1] * z);
}

void requireTwo(const Image& image, const char* where) {
  for (const std::uint32_t n : image.size)
    if (n < 2) throw ImportError(where, "fewer than two values are left along an axis", "leave more of the image");
}

}  // namespace

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
  for (std::size_t z = 0; z < out.size[2]; ++z)
    for (std::size_t y = 0; y < out.size[1]; ++y)
      for (std::size_t x = 0; x < out.size[0]; ++x) {
        double sum = 0;
        for (std::size_t c = 0; c < n; ++c)
          for (std::size_t b = 0; b < n; ++b)
            for (std::size_t a = 0; a < n; ++a) sum += image.values[indexOf(image, x * n + a, y * n + b, z * n + c)];
        out.values[indexOf(out, x, y, z)] = static_cast<float>(sum * share);
      }
  return out;
}

void smooth(Image& image, double sigma_mm) {
  const std::size_t stride[3] = {1, image.size[0], std::size_t{image.size[0]} * image.size[1]};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double sigma = sigma_mm / spacing(image, axis);
    const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3 * sigma));
    if (reach == 0) continue;
    std::vector<double> weight;
    double sum = 0;
    for (std::ptrdiff_t i = -reach; i <= reach; ++i) {
      weight.push_back(std::exp(-0.5 * static_cast<double>(i * i) / (sigma * sigma)));
      sum += weight.back();
    }
    const auto n = static_cast<std::ptrdiff_t>(image.size[axis]);
    std::vector<float> line(image.size[axis]);
    for (std::size_t start = 0; start < image.values.size(); ++start) {
      if (start / stride[axis] % image.size[axis] != 0) continue;  // Not the first of its line.
      for (std::ptrdiff_t i = 0; i < n; ++i) {
        double mean = 0;
        for (std::ptrdiff_t j = -reach; j <= reach; ++j)
          mean +=
              weight[static_cast<std::size_t>(j + reach)] *
              image
                  .values[start + stride[axis] * static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i + j, 0, n - 1))];
        line[static_cast<std::size_t>(i)] = static_cast<float>(mean / sum);
      }
      for (std::size_t i = 0; i < line.size(); ++i) image.values[start + stride[axis] * i] = line[i];
    }
  }
}

void chooseLabel(Image& image, float label) {
  for (float& v : image.values) v = v == label ? 1.0f : 0.0f;
}

}  // namespace hapticctl_import
