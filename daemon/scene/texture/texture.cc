#include "daemon/scene/texture/texture.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "daemon/scene/invalid.h"
#include "daemon/scene/texture/ar_model.h"
#include "proto/texture.h"

namespace hapticd {
namespace {

constexpr double kMostSpeed = 10, kMostForce = 100, kMostVariance = 1e8;  // [m/s, N, m^2/s^4]

/** Takes values from the front; the caller has checked the size. */
class Values {
 public:
  explicit Values(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  void take(T* to, std::size_t count) {
    std::memcpy(to, bytes_.data(), count * sizeof(T));
    bytes_ = bytes_.subspan(count * sizeof(T));
  }
  template <class T>
  [[nodiscard]] T take() {
    T value;
    take(&value, 1);
    return value;
  }

 private:
  std::span<const std::byte> bytes_;
};

Result<void> count(std::uint32_t value, std::uint32_t lower, std::uint32_t upper, const char* where) {
  if (value >= lower && value <= upper) return {};
  return invalid(where, fmt::format("{} is not between {} and {}", value, lower, upper));
}

/** The file may be larger: a memfd's size is given before what goes into it is known to the last byte. */
Result<void> holds(std::span<const std::byte> bytes, std::size_t needed) {
  if (bytes.size() >= needed) return {};
  return invalid("texture.bytes", fmt::format("{} bytes cannot hold what its counts ask for: {}", bytes.size(), needed),
                 "begin an upload of that size");
}

/** Between pixels that lie `stride` apart, the last of each `row` having no neighbour. */
SteepestStep steepest(const Relief& relief, bool down) {
  SteepestStep found;
  const std::uint32_t columns = relief.width - (down ? 0 : 1), rows = relief.height - (down ? 1 : 0);
  const std::size_t stride = down ? relief.width : 1;
  int most = 0;
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::size_t i = std::size_t{y} * relief.width + x;
      const int step = std::abs(int{relief.pixels[i + stride]} - int{relief.pixels[i]});
      if (step <= most) continue;
      most = step;
      found = {step / 65535.0, x, y};
    }
  }
  return found;
}

Result<Texture> parseRelief(std::span<const std::byte> bytes) {
  if (auto r = holds(bytes, sizeof(hd_relief_upload)); !r) return r.error();
  Values reader(bytes);
  const auto header = reader.take<hd_relief_upload>();
  if (auto r = count(header.width, HD_RELIEF_LEAST_SIDE, HD_RELIEF_MOST_SIDE, "relief.width"); !r) return r.error();
  if (auto r = count(header.height, HD_RELIEF_LEAST_SIDE, HD_RELIEF_MOST_SIDE, "relief.height"); !r) return r.error();
  const std::size_t pixels = std::size_t{header.width} * header.height;
  if (auto r = holds(bytes, sizeof header + pixels * sizeof(std::uint16_t)); !r) return r.error();
  Texture texture;
  texture.relief.width = header.width;
  texture.relief.height = header.height;
  texture.relief.pixels.resize(pixels);
  reader.take(texture.relief.pixels.data(), pixels);
  texture.relief.across = steepest(texture.relief, false);
  texture.relief.down = steepest(texture.relief, true);
  texture.relief.slopes = reliefSlopes(texture.relief.pixels, header.width, header.height);
  return texture;
}

Result<void> checkModel(const RecordedModel& model, const std::string& where) {
  if (auto r = inRange(model.speed, 0, kMostSpeed, where + ".speed", "m/s", "speeds of a hand"); !r) return r;
  if (auto r = inRange(model.force, 0, kMostForce, where + ".force", "N", "forces of a hand"); !r) return r;
  if (auto r = inRange(model.variance, 0, kMostVariance, where + ".variance", "m^2/s^4", "accelerations are in m/s^2");
      !r)
    return r;
  for (std::size_t i = 0; i < model.a.size(); ++i) {
    if (!std::isfinite(model.a[i]))
      return invalid(fmt::format("{}.a[{}]", where, i), "it is not finite", "fit it again");
  }
  if (isStable(model.a)) return {};
  return invalid(where + ".a", "the model is unstable: a pole lies on or outside the unit circle",
                 "fit it again, for example by Burg's method, which never does that");
}

Result<void> checkTriangle(const RecordedVibration& vibration, const std::uint32_t (&corner)[3],
                           const std::string& where) {
  for (const std::uint32_t c : corner) {
    if (c < vibration.models.size()) continue;
    return invalid(where, fmt::format("there is no model {}; the last is {}", c, vibration.models.size() - 1),
                   "indices count from 0");
  }
  const RecordedModel &a = vibration.models[corner[0]], &b = vibration.models[corner[1]],
                      &c = vibration.models[corner[2]];
  const double area = (b.speed - a.speed) * (c.force - a.force) - (b.force - a.force) * (c.speed - a.speed);
  if (std::abs(area) >= 1e-12) return {};
  return invalid(where, "its three models lie on one line of speed and force", "leave it out");
}

Result<Texture> parseVibration(std::span<const std::byte> bytes) {
  if (auto r = holds(bytes, sizeof(hd_vibration_upload)); !r) return r.error();
  Values reader(bytes);
  const auto header = reader.take<hd_vibration_upload>();
  if (auto r = count(header.models, 3, HD_VIBRATION_MOST_MODELS, "vibration.models"); !r) return r.error();
  if (auto r = count(header.triangles, 1, HD_VIBRATION_MOST_TRIANGLES, "vibration.triangles"); !r) return r.error();
  if (auto r = count(header.order, 1, HD_VIBRATION_MOST_ORDER, "vibration.order"); !r) return r.error();
  if (auto r = inRange(header.rate_hz, HD_VIBRATION_LEAST_RATE, HD_VIBRATION_MOST_RATE, "vibration.rate_hz", "Hz",
                       "of the samples that the models were made of");
      !r)
    return r.error();
  const std::size_t model_bytes = sizeof(hd_vibration_model) + header.order * sizeof(double);
  if (auto r = holds(bytes, sizeof header + header.models * model_bytes + header.triangles * 3 * sizeof(std::uint32_t));
      !r)
    return r.error();
  Texture texture;
  RecordedVibration& vibration = texture.vibration;
  vibration.rate_hz = header.rate_hz;
  for (std::uint32_t m = 0; m < header.models; ++m) {
    const auto numbers = reader.take<hd_vibration_model>();
    RecordedModel model{numbers.speed, numbers.force, numbers.variance, std::vector<double>(header.order)};
    reader.take(model.a.data(), model.a.size());
    if (auto r = checkModel(model, fmt::format("vibration.model[{}]", m)); !r) return r.error();
    vibration.models.push_back(std::move(model));
  }
  for (std::uint32_t t = 0; t < header.triangles; ++t) {
    std::uint32_t corner[3];
    reader.take(corner, 3);
    if (auto r = checkTriangle(vibration, corner, fmt::format("vibration.triangle[{}]", t)); !r) return r.error();
    vibration.triangles.push_back({static_cast<std::uint16_t>(corner[0]), static_cast<std::uint16_t>(corner[1]),
                                   static_cast<std::uint16_t>(corner[2])});
  }
  return texture;
}

}  // namespace

Result<Texture> parseTexture(std::span<const std::byte> bytes) {
  if (auto r = holds(bytes, sizeof(hd_texture_upload)); !r) return r.error();
  const auto head = Values(bytes).take<hd_texture_upload>();
  if (head.magic != HD_TEXTURE_MAGIC)
    return invalid("texture.magic", fmt::format("{:#x} is not HD_TEXTURE_MAGIC", head.magic), "see proto/texture.h");
  if (head.reserved != 0) return invalid("texture.reserved", "it is not zero");
  if (head.kind == HD_TEXTURE_RELIEF) return parseRelief(bytes);
  if (head.kind == HD_TEXTURE_VIBRATION) return parseVibration(bytes);
  return invalid("texture.kind", fmt::format("there is no kind {}", head.kind), "1: relief, 2: vibration");
}

}  // namespace hapticd
