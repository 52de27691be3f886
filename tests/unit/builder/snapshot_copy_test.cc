// A deformable mesh for a further servo: the builder's, whatever the first servo has made of its own.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "daemon/builder/build.h"
#include "tests/support/random.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

/** Where a pointer of a view leads, from the beginning of its memory. */
template <class T>
std::ptrdiff_t place(const SnapshotMemory& memory, const T* there) {
  return reinterpret_cast<const std::byte*>(there) - memory.mapping.data();
}

std::vector<std::ptrdiff_t> places(const SnapshotMemory& m) {
  const MeshView& v = m.view;
  const MeshView::Deform& d = v.deform;
  return {place(m, v.vertices),
          place(m, v.triangles),
          place(m, v.neighbours),
          place(m, v.nodes),
          place(m, v.corners),
          place(m, d.vertices),
          place(m, d.corners),
          place(m, d.nodes),
          place(m, d.parents),
          place(m, d.vertex_first),
          place(m, d.vertex_triangles),
          place(m, d.triangle_leaf),
          place(m, d.source_vertex),
          std::ptrdiff_t{v.vertex_count},
          std::ptrdiff_t{v.triangle_count},
          std::ptrdiff_t{v.node_count},
          std::ptrdiff_t{v.depth},
          std::ptrdiff_t{v.flags},
          std::ptrdiff_t{d.source_count}};
}

TEST(SnapshotCopy, IsTheMeshAsItWasBuiltAndItsOwn) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(torus(40, 30), HD_MESH_DEFORMABLE), monitor);
  ASSERT_TRUE(built.ok()) << toString(built.error());
  auto first = openSnapshot(std::move(*built->memfd.share()), false);
  const auto fresh = openSnapshot(std::move(*built->memfd.share()), false);
  ASSERT_TRUE(first.ok() && fresh.ok());
  const float aside[3] = {0.2f, 0.1f, 0.05f};
  ASSERT_EQ(moveVertex(first->view, 7, aside), ErrorCode::kOk);
  first->view.deform.moved = 3;

  auto copy = copySnapshot(std::move(*built->memfd.share()), *first, false);
  ASSERT_TRUE(copy.ok()) << toString(copy.error());
  EXPECT_EQ(places(*copy), places(*fresh));
  const auto bytes = copy->mapping.bytes(), as_built = fresh->mapping.bytes();
  ASSERT_EQ(bytes.size(), as_built.size());
  EXPECT_EQ(std::memcmp(bytes.data(), as_built.data(), bytes.size()), 0);
  EXPECT_EQ(copy->view.deform.moves, 0u);
  EXPECT_EQ(copy->view.deform.moved, 0);
  ASSERT_NE(copy->view.deform.motion, nullptr);
  EXPECT_NE(copy->view.deform.motion, first->view.deform.motion);
  ASSERT_EQ(moveVertex(copy->view, 3, aside), ErrorCode::kOk);
  EXPECT_NE(first->view.vertices[3][0], 0.2f) << "each has its own";
}

TEST(SnapshotCopy, IsOfSealedMemoryAlone) {
  const Built built = build(torus(8, 6), HD_MESH_DEFORMABLE);
  const auto open = Memfd::create("hapticd-test", built.memory.mapping.size());
  ASSERT_TRUE(open.ok());
  EXPECT_EQ(copySnapshot(std::move(*open->share()), built.memory, false).error().code, ErrorCode::kPermissionDenied);
}

/** Of a recording that begins: the copy as built was made before the servo stood still. */
TEST(SnapshotCopy, OfWhatHasMovedIsAsTheServoHasIt) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(torus(40, 30), HD_MESH_DEFORMABLE), monitor);
  ASSERT_TRUE(built.ok()) << toString(built.error());
  auto servo = openSnapshot(std::move(*built->memfd.share()), false);
  ASSERT_TRUE(servo.ok());
  const auto as_it_is = servo->mapping.bytes();
  std::vector<std::byte> room(as_it_is.size() + 63);  // A snapshot is read at multiples of 64.
  const std::span copy(room.data() + (-reinterpret_cast<std::uintptr_t>(room.data()) & 63), as_it_is.size());
  std::ranges::copy(as_it_is, copy.begin());
  Random random(1);
  for (std::uint32_t vertex = 0; vertex < servo->view.deform.source_count; vertex += 3) {
    float to[3];
    for (float& x : to) x = static_cast<float>(random.in(-0.2, 0.2));
    ASSERT_EQ(moveVertex(servo->view, vertex, to), ErrorCode::kOk);
  }
  EXPECT_NE(std::memcmp(copy.data(), as_it_is.data(), copy.size()), 0);
  copyMoved(as_it_is, copy);
  EXPECT_EQ(std::memcmp(copy.data(), as_it_is.data(), copy.size()), 0) << "the servo has changed what is not copied";
  EXPECT_FALSE(validateSnapshot(copy).ok()) << "its checksum is still that of the mesh as built";
  closeDeformed(copy);
  const auto whole = validateSnapshot(copy);
  EXPECT_TRUE(whole.ok()) << toString(whole.error());
}

}  // namespace
}  // namespace hapticd::test
