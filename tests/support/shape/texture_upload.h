/** @file
 * Textures as a client would upload them, byte by byte.
 */
#pragma once

#include <cstring>
#include <vector>

#include "proto/texture.h"

namespace hapticd::test {

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

inline std::vector<std::byte> reliefUpload(std::uint32_t width, std::uint32_t height,
                                           const std::vector<std::uint16_t>& pixels) {
  std::vector<std::byte> bytes;
  append(bytes, hd_relief_upload{{HD_TEXTURE_MAGIC, HD_TEXTURE_RELIEF, 0}, width, height});
  for (const std::uint16_t p : pixels) append(bytes, p);
  return bytes;
}

struct UploadedModel {
  hd_vibration_model numbers;
  std::vector<double> a;
};

inline std::vector<std::byte> vibrationUpload(const std::vector<UploadedModel>& models,
                                              const std::vector<std::uint32_t>& corners, double rate_hz = 10000) {
  std::vector<std::byte> bytes;
  const auto count = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
  append(bytes, hd_vibration_upload{{HD_TEXTURE_MAGIC, HD_TEXTURE_VIBRATION, 0},
                                    count(models.size()),
                                    count(corners.size() / 3),
                                    count(models.front().a.size()),
                                    0,
                                    rate_hz});
  for (const UploadedModel& m : models) {
    append(bytes, m.numbers);
    for (const double a : m.a) append(bytes, a);
  }
  for (const std::uint32_t c : corners) append(bytes, c);
  return bytes;
}

/** Three models and a triangle. */
inline std::vector<std::byte> vibrationUpload() {
  return vibrationUpload({{{0.02, 0.2, 1}, {-0.9, 0.2}}, {{0.3, 0.2, 4}, {-0.5, 0}}, {{0.02, 3, 9}, {0.1, -0.1}}},
                         {0, 1, 2});
}

}  // namespace hapticd::test
