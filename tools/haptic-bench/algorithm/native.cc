#include "tools/haptic-bench/algorithm/native.h"

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

Model modelOf(const haptic_algorithm_problem& problem) {
  Model model;
  for (std::uint32_t v = 0; v < problem.vertex_count; ++v) {
    const float* x = problem.vertices[v];
    model.vertices.push_back({x[0], x[1], x[2]});
  }
  for (std::uint32_t t = 0; t < problem.triangle_count; ++t) {
    const std::uint32_t* v = problem.triangles[t];
    model.triangles.push_back({v[0], v[1], v[2]});
  }
  return model;
}

void refuseBall(const haptic_algorithm_problem& problem) {
  if (problem.radius > 0) throw Failure("--radius", "this algorithm touches with a point only", "leave it out");
}

}  // namespace haptic_bench
