#include "daemon/recording/texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "proto/texture.h"

namespace hapticd {
namespace {

constexpr double kLeastArea = 1e-12;  // Of a triangle of models, twice, as of an upload's [N m/s].

Error bad(std::string what) { return {ErrorCode::kInvalidArgument, "texturePart", std::move(what), {}}; }

std::size_t pixelsOf(const ReliefView& relief) { return std::size_t{relief.width} * relief.height; }

/** Models have no count in the view: the triangles name all that are ever read. */
std::size_t modelsOf(const VibrationView& vibration) {
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < vibration.triangles; ++t) {
    for (const std::uint16_t corner : vibration.triangle[t]) count = std::max<std::size_t>(count, corner + 1u);
  }
  return count;
}

void write(const VibrationModel& in, proto::VibrationModel::Builder out) {
  out.setSpeed(in.speed);
  out.setForce(in.force);
  out.setPower(in.power);
  auto reflection = out.initReflection(kVibrationOrder);
  for (unsigned i = 0; i < kVibrationOrder; ++i) reflection.set(i, in.reflection[i]);
}

Result<VibrationModel> read(proto::VibrationModel::Reader in, unsigned index) {
  VibrationModel out{in.getSpeed(), in.getForce(), in.getPower(), {}};
  const auto reflection = in.getReflection();
  if (reflection.size() != kVibrationOrder)
    return bad(fmt::format("model {} has {} coefficients, not {}", index, reflection.size(), kVibrationOrder));
  for (unsigned i = 0; i < kVibrationOrder; ++i) {
    out.reflection[i] = reflection[i];
    if (!(std::abs(out.reflection[i]) < 1)) return bad(fmt::format("model {} is unstable", index));
  }
  const auto finite = [](double x) { return std::isfinite(x) && x >= 0; };
  if (!finite(out.speed) || !finite(out.force) || !finite(out.power))
    return bad(fmt::format("model {} has no speed, force or power that there can be", index));
  return out;
}

Result<RecordedTexture> read(proto::Vibration::Reader in) {
  RecordedTexture out;
  const auto models = in.getModels();
  const auto triangles = in.getTriangles();
  if (models.size() < 3 || models.size() > HD_VIBRATION_MOST_MODELS)
    return bad(fmt::format("{} models", models.size()));
  if (triangles.size() < 3 || triangles.size() % 3 != 0 || triangles.size() / 3 > HD_VIBRATION_MOST_TRIANGLES)
    return bad(fmt::format("{} corners of triangles", triangles.size()));
  for (unsigned i = 0; i < models.size(); ++i) {
    auto model = read(models[i], i);
    if (!model) return model.error();
    out.models.push_back(*model);
  }
  for (unsigned i = 0; i < triangles.size(); i += 3) {
    out.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    for (const std::uint16_t corner : out.triangles.back()) {
      if (corner >= models.size()) return bad(fmt::format("triangle {} has no model {}", i / 3, corner));
    }
    const VibrationModel &a = out.models[triangles[i]], &b = out.models[triangles[i + 1]],
                         &c = out.models[triangles[i + 2]];
    const double area = (b.speed - a.speed) * (c.force - a.force) - (b.force - a.force) * (c.speed - a.speed);
    if (!(std::abs(area) >= kLeastArea)) return bad(fmt::format("triangle {} has no area", i / 3));
  }
  return out;
}

}  // namespace

TextureView RecordedTexture::view() const {
  TextureView view;
  if (!pixels.empty()) {
    view.relief = {pixels.data(), width, height};
    return view;
  }
  VibrationView& out = view.vibration;
  out.model = models.data();
  out.triangle = triangles.data();
  out.triangles = static_cast<std::uint32_t>(triangles.size());
  out.findBounds();
  return view;
}

std::uint32_t partsOf(const TextureView& texture) {
  if (texture.relief.pixel == nullptr) return 1;
  return static_cast<std::uint32_t>((pixelsOf(texture.relief) + kReliefPartPixels - 1) / kReliefPartPixels);
}

void writePart(std::uint32_t entry, const TextureView& texture, std::uint32_t part, proto::TexturePart::Builder out) {
  out.setEntry(entry);
  if (texture.relief.pixel != nullptr) {
    auto relief = out.initRelief();
    relief.setWidth(texture.relief.width);
    relief.setHeight(texture.relief.height);
    const std::size_t offset = std::size_t{part} * kReliefPartPixels;
    const std::size_t count = std::min<std::size_t>(kReliefPartPixels, pixelsOf(texture.relief) - offset);
    relief.setOffset(static_cast<std::uint32_t>(offset));
    relief.setPixels({texture.relief.pixel + offset, count});
    return;
  }
  const VibrationView& vibration = texture.vibration;
  auto builder = out.initVibration();
  auto models = builder.initModels(static_cast<unsigned>(modelsOf(vibration)));
  for (unsigned i = 0; i < models.size(); ++i) write(vibration.model[i], models[i]);
  auto triangles = builder.initTriangles(3 * vibration.triangles);
  for (unsigned i = 0; i < triangles.size(); ++i) triangles.set(i, vibration.triangle[i / 3][i % 3]);
}

Result<std::optional<RecordedTexture>> TextureParts::take(proto::TexturePart::Reader part) {
  if (part.getEntry() >= kMaxTextures) return bad(fmt::format("entry {} of the texture table", part.getEntry()));
  if (part.isRelief()) return takeRelief(part.getEntry(), part.getRelief());
  if (pending()) return bad("a relief is not whole");
  if (!part.isVibration()) return bad("a kind that this program does not know");
  auto vibration = read(part.getVibration());
  if (!vibration) return vibration.error();
  vibration->entry = part.getEntry();
  return std::optional(std::move(*vibration));
}

Result<std::optional<RecordedTexture>> TextureParts::takeRelief(std::uint32_t entry, proto::ReliefPart::Reader part) {
  const auto side = [](std::uint32_t n) { return n >= HD_RELIEF_LEAST_SIDE && n <= HD_RELIEF_MOST_SIDE; };
  if (!side(part.getWidth()) || !side(part.getHeight()))
    return bad(fmt::format("a relief of {} x {} pixels", part.getWidth(), part.getHeight()));
  if (!relief_) {
    relief_.emplace();
    relief_->entry = entry;
    relief_->width = part.getWidth();
    relief_->height = part.getHeight();
  }
  const auto pixels = part.getPixels();
  const std::size_t whole = std::size_t{relief_->width} * relief_->height, have = relief_->pixels.size();
  if (entry != relief_->entry || part.getWidth() != relief_->width || part.getHeight() != relief_->height ||
      part.getOffset() != have || pixels.size() == 0 || pixels.size() > whole - have) {
    return bad("it does not follow the part before it");
  }
  for (const std::uint16_t pixel : pixels) relief_->pixels.push_back(pixel);
  if (relief_->pixels.size() < whole) return std::optional<RecordedTexture>();
  return std::exchange(relief_, std::nullopt);
}

}  // namespace hapticd
