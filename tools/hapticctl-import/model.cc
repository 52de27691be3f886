#include "tools/hapticctl-import/model.h"

#include <fmt/core.h>

#include <sstream>

#include "daemon/builder/vdb/write_vdb.h"
#include "daemon/builder/volume/mesh_volume.h"
#include "daemon/builder/volume/thin_walls.h"
#include "rt/volume/volume_view.h"
#include "tools/hapticctl-import/hand_over.h"

namespace hapticctl_import {
namespace {

ImportError inWords(const hapticd::Error& error) { return {error.where, error.what, error.remedy}; }

}  // namespace

std::string writeModel(const Surface& surface, double voxel_mm, const std::string& path) {
  std::vector<hapticd::Float3> vertices = surface.vertices;
  for (hapticd::Float3& v : vertices)
    for (float& x : v) x = static_cast<float>(static_cast<double>(x) * 1e-3);
  hapticd::VolumeOptions options;
  options.band_voxels = options.margin_voxels = 4;
  hapticd::BuildMonitor monitor;
  const auto image = hapticd::buildMeshVolume(vertices, surface.triangles, voxel_mm * 1e-3, options, monitor);
  if (!image) throw inWords(image.error());
  const auto view = hapticd::validateVolume(bytesOf(*image));
  if (!view) throw inWords(view.error());
  std::ostringstream file;
  const std::string source = fmt::format("volume {:016x}", view->header->checksum);
  if (const auto written = hapticd::writeVdb(file, *view, nullptr, source); !written) throw inWords(written.error());
  writeFile(path, std::move(file).str());
  const std::string thin = hapticd::noteOfThinWalls(*view);
  return fmt::format("level set of {} bricks, voxels of {:.4g} mm, {:.4g} cm3{}{}", view->brick_count, voxel_mm,
                     view->mass.volume * 1e6, thin.empty() ? "" : "\n  note: ", thin);
}

}  // namespace hapticctl_import
