// What is refused outright: numbers that mean nothing.
#include <fmt/core.h>

#include <cmath>
#include <cstring>

#include "daemon/builder/mesh/mesh.h"

namespace hapticd {
namespace {

constexpr const char* kAxis[] = {"x", "y", "z"};

/** The first triangle that uses a vertex, in words. */
std::string userOf(const MeshSource& source, std::uint32_t vertex) {
  for (std::size_t t = 0; t < source.triangles.size(); ++t) {
    for (const std::uint32_t v : source.triangles[t])
      if (v == vertex) return fmt::format(" (of triangle {})", t);
  }
  return " (of no triangle)";
}

Error badVertex(const MeshSource& source, std::uint32_t vertex) {
  for (int k = 0; k < 3; ++k) {
    const float x = source.vertices[vertex][k];
    if (std::fabs(x) <= HD_MAX_COORDINATE) continue;
    const std::string where = fmt::format("vertex {}{}", vertex, userOf(source, vertex));
    if (!std::isfinite(x))
      return {ErrorCode::kBadMesh, where, fmt::format("{} is {}", kAxis[k], x), "export the mesh again"};
    return {ErrorCode::kBadMesh, where,
            fmt::format("{} is {} m, beyond the {} m that a hand's world may have", kAxis[k], x, HD_MAX_COORDINATE),
            "check the scale: coordinates are in metres"};
  }
  return {};
}

Result<void> checkRequest(const MeshSource& source) {
  const hd_volume_request& r = source.request;
  if (!(r.voxel_m >= HD_MIN_VOXEL && r.voxel_m <= HD_MAX_VOXEL)) {
    return Error{ErrorCode::kInvalidArgument, "volume request", fmt::format("a voxel of {} m", r.voxel_m),
                 fmt::format("give {} to {} m", HD_MIN_VOXEL, HD_MAX_VOXEL)};
  }
  if (!(r.point_spacing_m >= 0 && r.point_spacing_m <= HD_MAX_VOXEL) || r.reserved[0] != 0 || r.reserved[1] != 0) {
    return Error{ErrorCode::kInvalidArgument, "volume request",
                 fmt::format("points {} m apart, or a reserved field that is not 0", r.point_spacing_m),
                 fmt::format("give 0 to {} m", HD_MAX_VOXEL)};
  }
  if (source.deformable) {
    return Error{ErrorCode::kUnsupported, "volume request", "a deformable mesh has no volume",
                 "load it as rigid, or without a voxel size"};
  }
  return {};
}

}  // namespace

Result<MeshSource> readUpload(std::span<const std::byte> upload) {
  hd_mesh_upload header;
  if (upload.size() < sizeof header)
    return Error{ErrorCode::kBadMesh, "upload", fmt::format("{} bytes cannot hold the header", upload.size()), {}};
  std::memcpy(&header, upload.data(), sizeof header);
  if (header.magic != HD_UPLOAD_MAGIC)
    return Error{ErrorCode::kBadMesh, "upload header", "the magic number is wrong", "fill in hd_mesh_upload"};
  const bool as_volume = (header.flags & HD_UPLOAD_VOLUME) != 0;
  constexpr std::uint32_t kKnown =
      static_cast<std::uint32_t>(HD_MESH_DEFORMABLE) | HD_UPLOAD_VOLUME | HD_UPLOAD_FILL_HOLES;
  if ((header.flags & ~kKnown) != 0)
    return Error{ErrorCode::kBadMesh, "upload header", fmt::format("unknown flags {:#x}", header.flags), {}};
  if ((header.flags & HD_UPLOAD_FILL_HOLES) != 0 && !as_volume)
    return Error{ErrorCode::kInvalidArgument, "upload header", "holes are filled in volumes alone", "ask for a volume"};
  if (header.weld_m != 0 && !(header.weld_m >= HD_MIN_WELD && header.weld_m <= HD_MAX_WELD)) {
    return Error{ErrorCode::kBadMesh, "upload header", fmt::format("a welding distance of {} m", header.weld_m),
                 fmt::format("give 0, or {} to {} m", HD_MIN_WELD, HD_MAX_WELD)};
  }
  if (header.triangle_count == 0 || header.vertex_count == 0) {
    return Error{
        ErrorCode::kBadMesh,
        "upload",
        fmt::format("{} vertices and {} triangles: the mesh is empty", header.vertex_count, header.triangle_count),
        {}};
  }
  if (header.vertex_count > HD_MAX_VERTICES || header.triangle_count > HD_MAX_TRIANGLES) {
    return Error{ErrorCode::kBadMesh, "upload",
                 fmt::format("{} vertices and {} triangles are too many", header.vertex_count, header.triangle_count),
                 fmt::format("at most {} and {}", HD_MAX_VERTICES, HD_MAX_TRIANGLES)};
  }
  const std::size_t vertex_bytes = std::size_t{header.vertex_count} * sizeof(Float3);
  const std::size_t triangle_bytes = std::size_t{header.triangle_count} * sizeof(Index3);
  const std::size_t bytes = sizeof header + vertex_bytes + triangle_bytes + (as_volume ? sizeof(hd_volume_request) : 0);
  if (upload.size() != bytes) {
    return Error{ErrorCode::kBadMesh,
                 "upload",
                 fmt::format("{} vertices and {} triangles take {} bytes, but {} came", header.vertex_count,
                             header.triangle_count, bytes, upload.size()),
                 {}};
  }
  MeshSource source;
  const std::byte* const p = upload.data() + sizeof header;
  source.vertices = {reinterpret_cast<const Float3*>(p), header.vertex_count};
  source.triangles = {reinterpret_cast<const Index3*>(p + vertex_bytes), header.triangle_count};
  source.weld_m = header.weld_m;
  source.deformable = (header.flags & HD_MESH_DEFORMABLE) != 0;
  source.as_volume = as_volume;
  source.fill_holes = (header.flags & HD_UPLOAD_FILL_HOLES) != 0;
  if (as_volume) {
    std::memcpy(&source.request, p + vertex_bytes + triangle_bytes, sizeof source.request);
    if (const auto checked = checkRequest(source); !checked) return checked.error();
  }
  return source;
}

Result<void> checkNumbers(const MeshSource& source) {
  for (std::size_t t = 0; t < source.triangles.size(); ++t) {
    for (const std::uint32_t v : source.triangles[t]) {
      if (v >= source.vertices.size()) {
        return Error{ErrorCode::kBadMesh, fmt::format("triangle {}", t),
                     fmt::format("index {} is past the last vertex, {}", v, source.vertices.size() - 1),
                     "export the mesh again"};
      }
    }
  }
  for (std::size_t v = 0; v < source.vertices.size(); ++v) {
    const auto& [x, y, z] = source.vertices[v];
    // One comparison each; NaN fails it.
    if (std::fabs(x) <= HD_MAX_COORDINATE && std::fabs(y) <= HD_MAX_COORDINATE && std::fabs(z) <= HD_MAX_COORDINATE)
      continue;
    return badVertex(source, static_cast<std::uint32_t>(v));
  }
  return {};
}

}  // namespace hapticd
