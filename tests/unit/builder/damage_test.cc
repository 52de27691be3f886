// A snapshot with any field or byte damaged is refused, also when the damager has made the checksum fit.
#include <functional>

#include "rt/scene/snapshot_checksum.h"
#include "tests/support/seeds.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

/** A snapshot in aligned private memory. */
class Copy {
 public:
  explicit Copy(std::uint32_t flags) {
    BuildMonitor monitor;
    auto built = buildSnapshot(upload(torus(8, 6), flags), monitor);
    EXPECT_TRUE(built.ok());
    auto mapping = built->memfd.map(Memfd::Access::kRead);
    EXPECT_TRUE(mapping.ok());
    size_ = mapping->size();
    bytes_.resize(size_ + 64);
    std::memcpy(data(), mapping->data(), size_);
  }
  std::byte* data() {
    const auto address = reinterpret_cast<std::uintptr_t>(bytes_.data());
    return bytes_.data() + (64 - address % 64) % 64;
  }
  std::size_t size() const { return size_; }
  std::span<const std::byte> span() { return {data(), size_}; }
  hd_snapshot_header& header() { return *reinterpret_cast<hd_snapshot_header*>(data()); }
  template <class T>
  T* section(hd_snapshot_section s) {
    return reinterpret_cast<T*>(data() + header().section[s].offset);
  }
  void fitChecksum() { header().checksum = snapshotChecksum(span().subspan(sizeof(hd_snapshot_header))); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t size_ = 0;
};

TEST(Damage, TheUndamagedPasses) {
  for (const std::uint32_t flags : {0u, static_cast<std::uint32_t>(HD_MESH_DEFORMABLE)}) {
    Copy copy(flags);
    const auto view = validateSnapshot(copy.span());
    ASSERT_TRUE(view.ok()) << toString(view.error());
    copy.fitChecksum();
    EXPECT_TRUE(validateSnapshot(copy.span()).ok());
  }
}

TEST(Damage, EveryByteIsUnderTheChecksumOrChecked) {
  Copy copy(HD_MESH_DEFORMABLE);
  for (std::size_t i = 0; i < copy.size(); ++i) {
    copy.data()[i] ^= std::byte{0x10};
    const auto view = validateSnapshot(copy.span());
    ASSERT_FALSE(view.ok()) << "byte " << i;
    EXPECT_EQ(view.error().code, ErrorCode::kBadSnapshot);
    copy.data()[i] ^= std::byte{0x10};
  }
  EXPECT_TRUE(validateSnapshot(copy.span()).ok());
}

TEST(Damage, EachRuleStandsWithoutTheChecksum) {
  struct Case {
    const char* what;  // part of the refusal
    std::function<void(Copy&)> damage;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto node = [](Copy& c, int i) -> hd_bvh_node& { return c.section<hd_bvh_node>(HD_SECTION_NODES)[i]; };
  // A leaf that is the first child of its node.
  const auto leaf = [&](Copy& c) -> hd_bvh_node& {
    int i = 0;
    while (node(c, i).count[0] == 0) ++i;
    return node(c, i);
  };
  const auto word = [](Copy& c, hd_snapshot_section s, int i) -> std::uint32_t& {
    return c.section<std::uint32_t>(s)[i];
  };
  const std::vector<Case> cases = {
      {"magic", [](Copy& c) { c.header().magic ^= 1; }},
      {"version", [](Copy& c) { c.header().version = 1; }},
      {"kind", [](Copy& c) { c.header().kind = 9; }},
      {"bytes", [](Copy& c) { c.header().total_bytes -= 64; }},
      {"flag is not known", [](Copy& c) { c.header().flags |= 4; }},
      {"vertex count", [](Copy& c) { c.header().vertex_count = 0; }},
      {"triangle count", [](Copy& c) { c.header().triangle_count = HD_MAX_TRIANGLES + 1; }},
      {"node count", [](Copy& c) { c.header().node_count = c.header().triangle_count + 1; }},
      {"node count", [](Copy& c) { c.header().node_count = 0; }},
      {"depth out of range", [](Copy& c) { c.header().depth = 65; }},
      {"the depth is", [](Copy& c) { c.header().depth += 1; }},
      {"valence", [](Copy& c) { c.header().max_valence += 1; }},
      {"root", [](Copy& c) { c.header().lower[0] -= 1; }},
      {"wrong size", [](Copy& c) { c.header().vertex_count -= 1; }},
      {"wrong size", [](Copy& c) { c.header().section[HD_SECTION_PARENTS].bytes -= 4; }},
      {"wrong size", [](Copy& c) { c.header().section[HD_SECTION_SOURCE_VERTEX].bytes -= 1; }},
      {"outside", [](Copy& c) { c.header().section[HD_SECTION_VERTICES].offset = 0; }},
      {"outside", [](Copy& c) { c.header().section[HD_SECTION_NODES].offset += 4; }},
      {"outside", [](Copy& c) { c.header().section[HD_SECTION_TRIANGLES].offset = ~std::uint64_t{63}; }},
      {"outside", [](Copy& c) { c.header().section[HD_SECTION_SOURCE_VERTEX].offset = c.size(); }},
      {"not its vertices", [](Copy& c) { c.section<float>(HD_SECTION_CORNERS)[13] += 1; }},
      {"coordinate", [&](Copy& c) { c.section<float>(HD_SECTION_VERTICES)[4] = kNan; }},
      {"coordinate", [](Copy& c) { c.section<float>(HD_SECTION_VERTICES)[4] = 101; }},
      {"past the last vertex", [&](Copy& c) { word(c, HD_SECTION_TRIANGLES, 7) = c.header().vertex_count; }},
      {"one vertex", [&](Copy& c) { word(c, HD_SECTION_TRIANGLES, 7) = word(c, HD_SECTION_TRIANGLES, 6); }},
      {"look back", [&](Copy& c) { word(c, HD_SECTION_NEIGHBOURS, 5) ^= 1; }},
      {"look back", [&](Copy& c) { word(c, HD_SECTION_NEIGHBOURS, 5) = 1u << 30; }},
      {"look back", [&](Copy& c) { word(c, HD_SECTION_NEIGHBOURS, 5) = 1; }},  // itself
      {"look back", [&](Copy& c) { word(c, HD_SECTION_NEIGHBOURS, 5) = HD_NO_INDEX; }},
      {"closed", [](Copy& c) { c.header().flags &= ~HD_MESH_CLOSED; }},
      {"not a box", [&](Copy& c) { node(c, 0).upper[1][2] = kNan; }},
      {"not a box", [&](Copy& c) { std::swap(node(c, 0).upper[1][3], node(c, 0).lower[1][3]); }},
      {"too many or none", [&](Copy& c) { node(c, 0).used = 0; }},
      {"too many or none", [&](Copy& c) { node(c, 0).used = HD_BVH_WIDTH + 1; }},
      {"too many or none", [&](Copy& c) { node(c, 1).used = 1u << 30; }},
      {"hold its children", [&](Copy& c) { node(c, 0).upper[1][0] -= 0.01f; }},
      {"hold its triangles", [&](Copy& c) { leaf(c).upper[1][0] = leaf(c).lower[1][0]; }},
      {"not after it", [&](Copy& c) { node(c, 0).child[0] = 0; }},
      {"not after it", [&](Copy& c) { node(c, 0).child[0] = c.header().node_count; }},
      {"two parents",
       [&](Copy& c) {
         const hd_bvh_node first = node(c, 0);
         for (int k = 0; k < 3; ++k) {
           std::fill_n(node(c, 0).lower[k], HD_BVH_WIDTH, -1.0f);
           std::fill_n(node(c, 0).upper[k], HD_BVH_WIDTH, 1.0f);
         }
         node(c, 0).child[1] = first.child[0];
       }},
      {"out of range", [&](Copy& c) { leaf(c).count[0] = HD_BVH_LEAF_TRIANGLES + 1; }},
      {"out of range", [&](Copy& c) { leaf(c).child[0] = c.header().triangle_count; }},
      {"two leaves",
       [&](Copy& c) {
         hd_bvh_node& n = leaf(c);
         for (int k = 0; k < 3; ++k) {
           n.lower[k][0] = *std::min_element(n.lower[k], n.lower[k] + n.used);
           n.upper[k][0] = *std::max_element(n.upper[k], n.upper[k] + n.used);
         }
         n.child[0] = n.child[1];
         n.count[0] = 1;
       }},
      {"no leaf", [&](Copy& c) { leaf(c).count[0] -= 1; }},
      {"the root has none", [&](Copy& c) { word(c, HD_SECTION_PARENTS, 0) = 0; }},
      {"not its parent", [&](Copy& c) { word(c, HD_SECTION_PARENTS, 5) ^= 1; }},
      {"hold it", [&](Copy& c) { word(c, HD_SECTION_TRIANGLE_LEAF, 9) ^= 1; }},
      {"begin at 0", [&](Copy& c) { word(c, HD_SECTION_VERTEX_FIRST, 0) = 1; }},
      {"as many", [&](Copy& c) { word(c, HD_SECTION_VERTEX_FIRST, 3) += 1; }},
      {"not its triangles", [&](Copy& c) { word(c, HD_SECTION_VERTEX_TRIANGLES, 8) = 1u << 31; }},
      {"not its triangles",
       [&](Copy& c) { word(c, HD_SECTION_VERTEX_TRIANGLES, 1) = word(c, HD_SECTION_VERTEX_TRIANGLES, 0); }},
      {"no vertex here", [&](Copy& c) { word(c, HD_SECTION_SOURCE_VERTEX, 2) = c.header().vertex_count; }},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Copy copy(HD_MESH_DEFORMABLE);
    cases[i].damage(copy);
    copy.fitChecksum();
    const auto view = validateSnapshot(copy.span());
    ASSERT_FALSE(view.ok()) << "case " << i << ": " << cases[i].what;
    EXPECT_NE(toString(view.error()).find(cases[i].what), std::string::npos) << i << ": " << toString(view.error());
  }
}

TEST(Damage, RandomDamageNeverEscapes) {
  // Whatever passes must be walkable; the sanitizer builds watch the walk.
  std::mt19937 random(seedOf(11));
  std::uint32_t passed = 0;
  for (int i = 0; i < 3000; ++i) {
    Copy copy(i % 2 == 0 ? 0 : HD_MESH_DEFORMABLE);
    const int changes = 1 + static_cast<int>(random() % 3);
    for (int k = 0; k < changes; ++k) {
      auto* const words = reinterpret_cast<std::uint32_t*>(copy.data());
      words[random() % (copy.size() / 4)] = random() % 3 == 0 ? random() : random() % 64;
    }
    copy.fitChecksum();
    const auto view = validateSnapshot(copy.span());
    if (!view) continue;
    ++passed;
    double sum = 0;
    for (std::uint32_t t = 0; t < view->triangle_count; ++t) sum += view->vertex(t, 0).norm();
    EXPECT_TRUE(std::isfinite(sum));
  }
  EXPECT_LT(passed, 3000u / 2);
}

TEST(Damage, ShortAndShiftedMemoryIsRefused) {
  Copy copy(0);
  for (std::size_t size = 0; size < copy.size(); size += 61)
    EXPECT_FALSE(validateSnapshot({copy.data(), size}).ok()) << size;
  std::vector<std::byte> shifted(copy.size() + 128);
  std::byte* const at = shifted.data() + (64 - reinterpret_cast<std::uintptr_t>(shifted.data()) % 64) + 8;
  std::memcpy(at, copy.data(), copy.size());
  EXPECT_FALSE(validateSnapshot({at, copy.size()}).ok());
}

TEST(Checksum, OneWordAnywhereChangesIt) {
  std::vector<std::byte> bytes(256);
  const std::uint64_t zero = snapshotChecksum(bytes);
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= std::byte(1u << bit % 8);
    EXPECT_NE(snapshotChecksum(bytes), zero);
    bytes[bit / 8] ^= std::byte(1u << bit % 8);
  }
}

TEST(OpenSnapshot, WantsTheSeals) {
  BuildMonitor monitor;
  auto built = buildSnapshot(upload(cube()), monitor);
  ASSERT_TRUE(built.ok());
  EXPECT_TRUE(openSnapshot(std::move(*built->memfd.share()), true).ok());
  auto mapping = built->memfd.map(Memfd::Access::kRead);
  auto open = Memfd::create("test", mapping->size());
  {
    auto writer = open->map(Memfd::Access::kWrite);
    std::memcpy(writer->data(), mapping->data(), mapping->size());
  }
  ASSERT_TRUE(open->seal(Seals::kFixedSize).ok());
  const auto refused = openSnapshot(std::move(*open->share()), false);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kPermissionDenied);
  ASSERT_TRUE(open->seal(Seals::kFrozen).ok());
  EXPECT_TRUE(openSnapshot(std::move(*open->share()), false).ok());
}

}  // namespace
}  // namespace hapticd::test
