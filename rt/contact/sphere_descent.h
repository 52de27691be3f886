/** @file
 * Detector (a): the thesis's descent of two octrees of implicit spheres (section 3.2), or of one against the other's
 * distance field.
 *
 * Pairs of nodes are held level by level. In each step the side with the larger nodes is refined in every pair: its
 * children's spheres, tight about the octants that they occupy, are tested against the other node's. Only surface is
 * walked; child offsets are turned into B's lattice once per query. In the end each voxel of a small node of A is tried
 * against the voxels of B right about it, if the budget is enough for that.
 *
 * Sensation preserving (section 3.2.5, Otaduy and Lin 2003): a pair whose weighted surface deviation
 * s* = max(phi_a, phi_b) / max(D_a, D_b) (eq. 3.5) is below s_0 is not refined: it is a contact as large as its cell.
 * Finished here: with too little budget for a step, the pairs of largest s* are refined as far as it goes, so s_0
 * follows from the budget. Needs the volumes' sensation sections; without, deep pairs go first.
 *
 * A node's sphere holds its voxels, not their spheres: voxels that overlap are always found, of those whose spheres
 * alone do most are.
 *
 * Whether they touch at all is first asked of the few pairs of each level whose centres are nearest, which tells of
 * most that do; of the others all pairs are asked.
 *
 * One-sided, a voxel of A that is left becomes a point of A's surface, which B's field is asked for: depth, direction
 * and area as of PointFieldDetector, up to DetectorQuery::margin.
 *
 * A unit of work is sixteen sphere tests. Spheres against spheres tell where bodies touch to a voxel; how deep and in
 * which direction is read from B's field at each contact's mean place on A. So shallow contacts may be reported apart,
 * with a negative depth.
 */
#pragma once

#include <vector>

#include "rt/contact/detector.h"
#include "rt/contact/point_kernel.h"
#include "rt/contact/touch_group.h"

namespace hapticd {

enum class SphereLeaf : std::uint8_t {
  kSphere,     ///< Spheres against spheres, down to the voxels of both.
  kFieldValue  ///< One-sided: A's spheres against the value of B's field; B's tree is not walked. A needs its own.
};

struct SphereDescentOptions {
  SphereLeaf leaf = SphereLeaf::kSphere;
  bool tight = true;     ///< Spheres about the occupied octants; else about the node.
  double threshold = 0;  ///< s_0 [1/m^2]; 0: all is refined.
  std::uint32_t max_pairs =
      1u << 18;  ///< Held at a time, for each of two lists of 36 bytes, and 24 more; what is beyond is dropped.
};

class SphereDescentDetector final : public Detector {
 public:
  explicit SphereDescentDetector(const SphereDescentOptions& options = {});
  ~SphereDescentDetector() override;

  [[nodiscard]] const char* name() const noexcept override {
    return options_.leaf == SphereLeaf::kSphere ? "sphere descent" : "sphere descent, one-sided";
  }
  void find(const DetectorQuery& query, ContactSet& contacts) HD_RT override;
  void reset() HD_RT override { ages_.clear(); }

 private:
  struct Pair;
  struct Tree;
  struct Run;
  struct Offsets;
  struct Met;
  struct Sphere;

  void descend(Run& run) HD_RT;
  void walk(Run& run, std::uint32_t most) HD_RT;
  void keepNearest(Run& run, std::uint32_t most) HD_RT;
  void refine(Run& run, bool side_a) HD_RT;
  void refineA(Run& run, const OctreeLevel& level, const Offsets& offset) HD_RT;
  void refineB(Run& run, const OctreeLevel& level, const Offsets& offset) HD_RT;
  void put(std::uint32_t at, const Sphere& sphere) HD_RT;
  [[nodiscard]] std::uint64_t near(std::uint32_t first, std::uint32_t count, const Sphere& sphere) const HD_RT;
  void push(Run& run, const Pair& pair, std::uint32_t& made) HD_RT;
  [[nodiscard]] bool windowsFit(const Run& run) const HD_RT;
  void meetWindows(Run& run) HD_RT;
  [[nodiscard]] bool isNew(const Run& run, std::uint32_t voxel_a) HD_RT;
  void refineToVoxels(Run& run, bool side_a, const OctreeLevel& level, const Offsets& offset) HD_RT;
  void choose(Run& run, bool side_a) HD_RT;
  void touch(Run& run, const Pair& pair, float distance, float reach) HD_RT;
  void walkField(Run& run) HD_RT;
  void makeRoom(Run& run, std::uint32_t count, std::uint32_t group) HD_RT;
  void lookUp(Run& run, const Pair& pair) HD_RT;
  void lookUpVoxels(Run& run, const Pair& node, const OctreeLevel& level, const Offsets& offset) HD_RT;
  void flush(Run& run) HD_RT;
  void findParts(std::uint32_t level) HD_RT;
  void sum(Run& run, ContactSet& contacts) HD_RT;

  SphereDescentOptions options_;
  std::vector<Pair> now_, next_;
  std::vector<float> urgency_, sorted_;
  std::vector<float> sphere_[4];  ///< x, y, z and radius of those that one is tried against.
  GroupMap map_;
  std::vector<TouchGroup> groups_;   ///< Their means and areas are sums until the end.
  std::vector<std::uint32_t> part_;  ///< First part under each node of a level above the parts'.
  std::vector<std::uint64_t> seen_;  ///< A's voxels that touched: a mask for each node of the last level.
  std::vector<float> x_, y_, z_;     ///< One-sided: centres of voxels, then points of A's surface, in A.
  std::vector<std::uint16_t> area_;  ///< That each stands for.
  ContactAges ages_;
};

}  // namespace hapticd
