#include "tools/haptic-bench/model/mesh_file.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <vector>

#include "proto/snapshot.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/interrupt.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/read_mesh.h"

namespace haptic_bench {
namespace {

using hapticd_mesh_file::MeshError;
using hapticd_mesh_file::MeshFile;

MeshFile read(const std::string& path) {
  const Interrupts interrupts;
  const auto check = [&] { checkInterrupts(path.c_str(), "a file that takes so long may be damaged"); };
  try {
    MeshFile file = hapticd_mesh_file::readMesh(path, "haptic-bench", interrupted);
    check();  // Whoever has interrupted it just now need not do so again.
    return file;
  } catch (const MeshError& error) {
    check();
    throw Failure(path, error.what(), error.remedy.empty() ? "a mesh file: STL, OBJ, PLY ..." : error.remedy);
  }
}

}  // namespace

Model readMeshFile(const std::string& path, double scale) {
  const MeshFile file = read(path);
  Model model;
  model.kind = "file";
  std::map<std::array<float, 3>, std::uint32_t> places;  // Scaled, two may round to one.
  std::vector<std::uint32_t> number;
  for (const auto& v : file.vertices) {
    const Vec3 x = scale * Vec3(v[0], v[1], v[2]);
    if (!(x.cwiseAbs().maxCoeff() <= HD_MAX_COORDINATE)) {
      throw Failure(path, fmt::format("the vertex {:g} {:g} {:g} lies {:.4g} m away", v[0], v[1], v[2], x.norm()),
                    fmt::format("at most {} m: the file's unit may be another, add :scale=mm", HD_MAX_COORDINATE));
    }
    const Eigen::Vector3f rounded = x.cast<float>();
    const auto [place, fresh] = places.try_emplace({rounded.x(), rounded.y(), rounded.z()}, 0);
    if (fresh) place->second = model.addVertex(x);
    number.push_back(place->second);
  }
  for (const auto& [a, b, c] : file.triangles) model.triangles.push_back({number[a], number[b], number[c]});
  return model;
}

}  // namespace haptic_bench
