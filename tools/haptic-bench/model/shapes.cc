#include "tools/haptic-bench/model/shapes.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

/** z = f(x, y) on a grid over the square, facing up. */
template <class F>
void addHeights(Model& model, double half, std::uint32_t cells, F f) {
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) {
      const double x = -half + 2 * half * i / cells, y = -half + 2 * half * j / cells;
      model.addVertex({x, y, f(x, y)});
    }
  }
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i;
      model.addQuad(a, a + 1, a + cells + 2, a + cells + 1);
    }
  }
}

}  // namespace

Model sphere(double radius, int stacks) {
  Model model;
  model.kind = "sphere";
  model.radius = radius;
  const auto rings = static_cast<std::uint32_t>(stacks), slices = 2 * rings;
  const std::uint32_t north = model.addVertex({0, 0, radius});
  for (std::uint32_t i = 1; i < rings; ++i) {
    for (std::uint32_t j = 0; j < slices; ++j) {
      const double polar = EIGEN_PI * i / rings, azimuth = 2 * EIGEN_PI * j / slices;
      model.addVertex(radius *
                      Vec3(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)));
    }
  }
  const std::uint32_t south = model.addVertex({0, 0, -radius});
  const auto at = [slices](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * slices + j % slices; };
  for (std::uint32_t j = 0; j < slices; ++j) {
    model.triangles.push_back({north, at(1, j), at(1, j + 1)});
    for (std::uint32_t i = 1; i + 1 < rings; ++i) {
      model.addQuad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
    model.triangles.push_back({at(rings - 1, j), south, at(rings - 1, j + 1)});
  }
  return model;
}

Model plane(double half, int cells) {
  Model model;
  model.kind = "plane";
  model.half = half;
  addHeights(model, half, static_cast<std::uint32_t>(cells), [](double, double) { return 0.0; });
  return model;
}

Model ridge(double angle, double height, double half) {
  Model model;
  model.kind = "ridge";
  model.angle = angle;
  model.height = height;
  model.half = half;
  const double foot = height / std::tan(angle);
  if (foot >= half) {
    throw Failure("ridge, height",
                  fmt::format("its foot at x = {:.4g} m lies beyond the plane's end at {} m", foot, half),
                  "a lower or steeper ridge, or more half");
  }
  const double profile[][2] = {{-half, 0}, {-foot, 0}, {0, height}, {foot, 0}, {half, 0}};
  for (const auto& [x, z] : profile) {
    model.addVertex({x, -half, z});
    model.addVertex({x, half, z});
  }
  for (std::uint32_t a = 0; a < 8; a += 2) model.addQuad(a, a + 2, a + 3, a + 1);
  return model;
}

Model bowl(double radius, double half, double edge) {
  if (half >= 0.7 * radius) {
    throw Failure("bowl, half", fmt::format("{} m reaches the rim of a bowl of {} m", half, radius),
                  "at most 0.7 of the radius");
  }
  const double cells = std::ceil(2 * half / edge);
  if (cells > 2000) throw Failure("bowl, edge", "more than 8 million triangles", "longer edges or a smaller half");
  Model model;
  model.kind = "bowl";
  model.radius = radius;
  model.half = half;
  addHeights(model, half, static_cast<std::uint32_t>(cells),
             [radius](double x, double y) { return radius - std::sqrt(radius * radius - x * x - y * y); });
  return model;
}

}  // namespace haptic_bench
