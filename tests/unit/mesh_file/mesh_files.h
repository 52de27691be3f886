/** @file
 * Mesh files that a test writes, and what is read of them or refused.
 */
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "tests/support/process/temporary_directory.h"
#include "tools/mesh_file/child.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/read_mesh.h"

namespace hapticd_mesh_file {

inline bool never() { return false; }

class ReadMeshTest : public ::testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    std::ofstream(directory_ / name, std::ios::binary) << text;
    return (directory_ / name).string();
  }
  std::string refusal(const std::string& path, const std::function<bool()>& interrupted = never) {
    try {
      (void)readMesh(path, "the test", interrupted);
    } catch (const MeshError& error) {
      return error.what();
    }
    return "not refused";
  }

  static std::string refusalOf(const std::function<MeshFile()>& read,
                               const std::function<bool()>& interrupted = never) {
    try {
      (void)readInChild(read, interrupted);
    } catch (const MeshError& error) {
      return error.what();
    }
    return "not refused";
  }

  hapticd::test::TemporaryDirectory temporary_;
  const std::filesystem::path directory_ = temporary_.path();
};

inline double areaOf(const MeshFile& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    sum += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  return sum;
}

}  // namespace hapticd_mesh_file
