#include "daemon/scene/texture/relief_slopes.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace hapticd {
namespace {

constexpr int kBins = 256;
constexpr double kQuarters = 4 * 65535.0;  // Slopes are counted in quarters of a grey.

/** Of all slopes that are about as steep across: the steepest across and the steepest down. */
struct Bin {
  int across = -1, down = -1;
  std::uint32_t column = 0, row = 0;
};

class Bins {
 public:
  explicit Bins(int most_across) : per_quarter_((kBins - 0.5F) / static_cast<float>(std::max(most_across, 1))) {}
  void add(int across, int down, std::uint32_t column, std::uint32_t row) {
    across = std::abs(across);
    down = std::abs(down);
    Bin& bin = bins_[static_cast<std::size_t>(static_cast<float>(across) * per_quarter_)];
    if (across <= bin.across && down <= bin.down) return;
    if (down > bin.down) {
      bin.column = column;
      bin.row = row;
    }
    bin.across = std::max(bin.across, across);
    bin.down = std::max(bin.down, down);
  }
  [[nodiscard]] std::vector<ReliefSlope> taken() const {
    std::vector<ReliefSlope> out;
    int down = -1;
    for (auto bin = bins_.rbegin(); bin != bins_.rend(); ++bin) {
      if (bin->down <= down) continue;  // Another is steeper across and no less so down.
      down = bin->down;
      out.push_back({bin->across / kQuarters, bin->down / kQuarters, bin->column, bin->row});
    }
    return out;
  }

 private:
  float per_quarter_;
  std::array<Bin, kBins> bins_;
};

}  // namespace

// About a pixel the gradient of the B-spline through it and its neighbours is a mean of nine (Bernstein's form, both
// parts raised to degree 2): at the pixel, towards its neighbours and towards its corners. Beyond an edge the picture
// is mirrored: the neighbour is the pixel itself.
std::vector<ReliefSlope> reliefSlopes(std::span<const std::uint16_t> pixels, std::uint32_t width,
                                      std::uint32_t height) {
  const auto at = [&](std::uint32_t x, std::uint32_t y) { return int{pixels[std::size_t{y} * width + x]}; };
  int most = 0;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x + 1 < width; ++x) most = std::max(most, std::abs(at(x + 1, y) - at(x, y)));
  }
  Bins bins(4 * most);
  for (std::uint32_t y = 0; y < height; ++y) {
    const std::uint32_t above = y == 0 ? 0 : y - 1, below = std::min(y + 1, height - 1);
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::uint32_t left = x == 0 ? 0 : x - 1, right = std::min(x + 1, width - 1);
      // From the neighbour before to the one behind, of this pixel and of those to the right and below.
      const int across = at(right, y) - at(left, y), across_below = at(right, below) - at(left, below);
      const int down = at(x, below) - at(x, above), down_right = at(right, below) - at(right, above);
      const int step = at(right, y) - at(x, y), step_below = at(right, below) - at(x, below);
      const int fall = at(x, below) - at(x, y), fall_right = at(right, below) - at(right, y);
      bins.add(2 * across, 2 * down, x, y);
      bins.add(4 * step, down + down_right, x, y);
      bins.add(across + across_below, 4 * fall, x, y);
      bins.add(2 * (step + step_below), 2 * (fall + fall_right), x, y);
    }
  }
  return bins.taken();
}

}  // namespace hapticd
