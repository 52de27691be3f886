// The mesh files that we read ourselves: whatever they hold, refused with words or faces that are whole. And what we
// look into before assimp reads it.
#include <cstdint>
#include <cstdlib>
#include <numeric>

#include "tools/mesh_file/assimp/dxf.h"
#include "tools/mesh_file/assimp/three_mf.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/off.h"
#include "tools/mesh_file/own/ply.h"
#include "tools/mesh_file/own/stl.h"
#include "tools/mesh_file/own/x3d.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd_mesh_file;
  for (const auto parse : {parsePly, parseStl, parseOff}) {
    try {
      const Polygons mesh = parse({reinterpret_cast<const char*>(data), size});
      const std::size_t corners = mesh.corners.size();
      if (std::accumulate(mesh.sizes.begin(), mesh.sizes.end(), std::size_t{0}) != corners) std::abort();
      if (corners > 3 * size || mesh.vertices.size() > size) std::abort();  // Each takes a byte; of a strip's thrice.
    } catch (const MeshError& error) {
      if (*error.what() == 0 || error.remedy.empty()) std::abort();
    }
  }
  for (const auto look : {requirePlainInserts, requireModelsOnly}) {
    try {
      look({reinterpret_cast<const char*>(data), size});
    } catch (const MeshError& error) {
      if (*error.what() == 0 || error.remedy.empty()) std::abort();
    }
  }
  try {
    const auto no_others = [](const std::string&) { return std::string(); };
    for (const Polygons& shape : parseX3d({reinterpret_cast<const char*>(data), size}, no_others)) {
      if (std::accumulate(shape.sizes.begin(), shape.sizes.end(), std::size_t{0}) != shape.corners.size()) std::abort();
    }
  } catch (const MeshError& error) {
    if (*error.what() == 0 || error.remedy.empty()) std::abort();
  }
  return 0;
}
