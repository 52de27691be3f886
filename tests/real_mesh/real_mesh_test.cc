/** @file
 * Hands on parts as people draw them: needles, doubled faces, solids in solids, holes. The meshes come with the package
 * occt-misc (tools/setup); HAPTICD_MESHES names another folder, whose STL, OBJ, OFF and PLY files are then felt.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "daemon/builder/build.h"
#include "daemon/ipc/snapshot_memory.h"
#include "tests/support/for_seeds.h"
#include "tests/support/stepped/test_scene.h"
#include "tests/unit/builder/meshes.h"
#include "tools/mesh_file/read_mesh.h"

namespace hapticd {
namespace {

using test::TestScene;

constexpr double kSize = 0.1;  // Of all of them [m].
constexpr int kTicks = 3000;
constexpr int kStill = 25;  // Ticks after which a hand at rest has come to rest.

std::vector<std::filesystem::path> files() {
  const char* const folder = std::getenv("HAPTICD_MESHES");
  std::vector<std::filesystem::path> all;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder != nullptr ? folder : "/usr/share/opencascade/data/stl")) {
    const std::string ending = entry.path().extension();
    if (ending == ".stl" || ending == ".obj" || ending == ".off" || ending == ".ply") all.push_back(entry.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

/** Brought to size about zero, built as the daemon does. */
SnapshotMemory load(const std::filesystem::path& path) {
  auto file = hapticd_mesh_file::readMesh(path.string(), "the test", [] { return false; });
  double size = 0;
  for (int k = 0; k < 3; ++k) size = std::max(size, file.upper[k] - file.lower[k]);
  for (auto& v : file.vertices)
    for (int k = 0; k < 3; ++k)
      v[k] = static_cast<float>(kSize / size * (v[k] - 0.5 * (file.lower[k] + file.upper[k])));
  BuildMonitor monitor;
  auto built = buildSnapshot(test::upload({file.vertices, file.triangles}), monitor);
  return std::move(*openSnapshot(std::move(*built->memfd.share()), false));
}

/** A hand that looks for the surface, strokes it at some depth, and rests there now and then. */
class StrokingHand {
 public:
  StrokingHand(Random& random, const MeshView& mesh) : random_(random), mesh_(mesh) {}

  const Vec3& next(const SurfaceContact& contact) {
    const bool rests = contact.object != 0 && tick_ % 400 > 340;
    still_ = rests ? still_ + 1 : 0;
    if (!rests) x_ += contact.object == 0 ? seek() : stroke(contact);
    ++tick_;
    return x_;
  }
  [[nodiscard]] bool hasRested() const { return still_ > kStill; }

 private:
  Vec3 seek() {
    if (tick_ % 500 == 0) {
      aim_ = mesh_.vertex(random_.below(mesh_.triangle_count), 0);
      if (random_.once(2)) aim_ += random_.vector(1e-3);
    }
    const Vec3 way = aim_ - x_;
    return std::min(1.0, 5e-4 / way.norm()) * way;
  }
  Vec3 stroke(const SurfaceContact& contact) {
    along_ += random_.vector(0.1);
    along_ -= along_.dot(contact.normal) * contact.normal;
    const Vec3 way = step_ * along_.normalized() + (contact.depth - depth_) * contact.normal;
    return std::min(1.0, 2 * step_ / way.norm()) * way;
  }

  Random& random_;
  const MeshView& mesh_;
  const double depth_ = std::pow(10, random_.in(-4, -2.3)), step_ = std::pow(10, random_.in(-5.3, -3));
  Vec3 x_ = Vec3(0, 0, 2 * kSize), aim_ = Vec3::Zero(), along_ = Vec3::UnitX();
  int tick_ = 0, still_ = 0;
};

void feel(MeshView& mesh, unsigned seed, int& contacts) {
  Random random(seed);
  const double radius = random.once(2) ? 0 : std::pow(10, random.in(-4, -2.7));
  const double mu = random.once(2) ? 0 : random.in(0.1, 1);
  TestScene kept, plain;  // The second asks the tree for everything.
  plain.proxy.keepSurroundings(false);
  for (TestScene* t : {&kept, &plain}) {
    t->addMesh(&mesh, {}, {1000, 0, mu, 0.8 * mu});
    t->proxy.setRadius(radius);
    t->tick(Vec3(0, 0, 2 * kSize));
  }
  StrokingHand hand(random, mesh);
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 before = kept.contact.proxy, hip = hand.next(kept.contact);
    const SurfaceContact &c = kept.tick(hip), &other = plain.tick(hip);
    contacts += c.object != 0;
    ASSERT_TRUE(c.force.allFinite()) << "tick " << i;
    ASSERT_EQ(c.force, other.force) << "what is kept changes a bit, tick " << i;
    ASSERT_EQ(c.proxy, other.proxy) << "what is kept changes a bit, tick " << i;
    ASSERT_LE((c.proxy - hip).norm(), (1 + 1e-6) * (before - hip).norm() + 1e-9) << "the spring gains, tick " << i;
    if (hand.hasRested() && c.object != 0) {
      ASSERT_LT((c.proxy - before).norm(), 1e-6) << "there is no rest, tick " << i;
    }
  }
}

TEST(RealMesh, KeepsWhatIsPromisedOfAnyMesh) {
  const auto all = files();
  ASSERT_FALSE(all.empty()) << "run tools/setup";
  for (const auto& path : all) {
    SCOPED_TRACE(path.filename());
    SnapshotMemory memory = load(path);
    int contacts = 0;
    forSeeds(6, [&](unsigned seed) { feel(memory.view, seed, contacts); });
    EXPECT_GT(contacts, kTicks / 3) << "it is hardly felt";
  }
}

}  // namespace
}  // namespace hapticd
