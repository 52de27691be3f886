/** @file
 * Contacts of a tool with the scene, within a budget: where tool and obstacle both have a volume, the tool's surface
 * points against the obstacle's distance field (rt/contact/point_field.h); else points of the tool against the nearest
 * point of each primitive or mesh.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/body/contact_model.h"
#include "rt/collide/request.h"
#include "rt/collide/tool_points.h"
#include "rt/contact/point_field.h"
#include "rt/volume/volume_table.h"

namespace hapticd {

/**
 * Of one device's tool; keeps the points of the last tool it was asked for, and which of them touched. Points that
 * touched last time are tried first, with 13 sixteenths of the budget, then the others, then what is left of the first;
 * both go on where they ended, so that a budget that is too small still gets round. The last sixteenth is for dropping,
 * of what is found, mere seams between obstacles.
 *
 * Obstacles for which the budget was not enough keep the contacts of the answer before, for a tenth of a second, and
 * come first the next time: an answer that is late must not say that nothing touches.
 *
 * A tool that is faster than the field's margin reaches until the next answer is told of what it will meet, from the
 * way that it will go: a plane that it has not reached stops it there, one that it has passed could only push it back.
 *
 * An open mesh without a volume is a wall from both sides: for each point the one that it came from counts until it has
 * left the sheet, one of them was put elsewhere, or the sheet was not asked about.
 *
 * What stands in the scene between two points of the tool is found, too: its balls, discs, edges and ridges are tried
 * against the tool's surface (round_obstacle.cc, edge_obstacle.cc, mantle_obstacle.cc, mesh_edge_obstacle.cc). A point
 * that has gone into a mesh is followed as deep as it goes, in steps of kReach at most; one that begins deeper is found
 * where that mesh has a volume.
 */
class SceneContacts {
 public:
  static constexpr std::uint32_t kPatches = 1u << 14;      ///< Of the largest tool: some 40 cm at 0.5 mm.
  static constexpr std::uint32_t kBodyPatches = 1u << 12;  ///< Of the largest free body: half as long.
  static constexpr double kReach = 0.01;                   ///< [m]
  static constexpr double kMargin =
      0.002;  ///< Contacts up to this far apart are reported, and more for fast tools [m].
  static constexpr std::uint32_t kWorkOfOne = 4000;  ///< Most tree nodes and triangles for one point.
  static constexpr double kSameWay = 0.999;          ///< Cosine of normals that say the same: within 2.6 degrees.

  /** `patches`: of the largest volume whose points meet fields; a larger one is tried by the points of its mesh. */
  explicit SceneContacts(std::uint32_t patches = kPatches) : patches_(patches), field_(patches) {}

  /** Contacts within kMargin plus what the tool may move in `ahead` seconds; `model` still holds the answer before.
   * Work units: as NearestQuery::work. */
  void find(const CollideRequest::Held& held, double ahead, const WorkBudget& budget, ContactModel& model,
            DetectorReport& report) HD_RT;
  /** It was not asked about: what is asked next may have come there on any way. */
  void forget() HD_RT { last_count_ = 0; }
  /** Which meshes have a volume; null: none. Before the first find(). */
  void setVolumes(const VolumeTable* volumes) { volumes_ = volumes; }

 private:
  /** Where a point stands against one obstacle, in its frame. */
  struct PointTouch {
    Vec3 surface;                          ///< Nearest point of it.
    Vec3 out;                              ///< Unit, outward there.
    double gap;                            ///< Negative: inside [m].
    std::uint32_t triangle = HD_NO_INDEX;  ///< Of a mesh.
    bool border = false;                   ///< Of a sheet: where it ends.
  };
  [[nodiscard]] const VolumeView* volumeOf(const Shape& shape) const HD_RT;
  /** Asks the field of obstacle k; false where there is none, or no room for the tool's points. */
  bool tryVolume(std::uint32_t k, const CollideRequest::Held& held, double ahead, const WorkBudget& budget,
                 DetectorReport& report) HD_RT;
  /** Adds what tool and obstacle k will meet within `ahead` seconds if both go on as they move; `query` as now. */
  void lookAhead(std::uint32_t k, const CollideRequest::Held& held, double ahead, DetectorQuery& query,
                 DetectorReport& report) HD_RT;
  /** To field_found_; notes if the time was not enough. */
  void findIn(std::uint32_t k, const DetectorQuery& query) HD_RT;
  /** field_found_'s contacts and report become part of the answer. */
  void keepFound(std::uint32_t k, const CollideRequest::Held& held, DetectorReport& report) HD_RT;
  /** A body at one question. */
  struct Stood {
    std::uint32_t slot = 0;    ///< 0: the tool.
    std::uint64_t number = 0;  ///< Of its shape: the next in that slot is another.
    Pose X_WO;
    std::uint64_t arrived = 0;
    std::uint32_t cut = 0;  ///< Questions since there was time for all of it.
  };
  [[nodiscard]] static Stood stoodOf(const CollideRequest::Held& held) HD_RT {
    return {0, held.shape.number, held.X_WO, held.arrived, 0};
  }
  [[nodiscard]] static Stood stoodOf(const CollideRequest::Obstacle& obstacle) HD_RT {
    return {obstacle.slot, obstacle.shape.number, obstacle.X_WO, obstacle.arrived, 0};
  }
  /** The same at the last question; null: it was not named there, or has been put elsewhere. */
  [[nodiscard]] const Stood* then(const Stood& now) const HD_RT;
  /** Where it stood at the last question; where it is now, if it was not named there or has been put elsewhere. */
  [[nodiscard]] Pose before(const Stood& now) const HD_RT;
  void remember(const CollideRequest::Held& held) HD_RT;
  void forgetSides(const CollideRequest::Held& held) HD_RT;
  [[nodiscard]] std::uint32_t firstOf(const CollideRequest::Held& held) const HD_RT;
  /** Of one question: the points that touched before, those that have had their turn, and that are known by that. */
  struct Tries {
    std::array<bool, ToolPoints::kMost> was_hot{}, tried{}, known{};
  };
  void carryOver(const CollideRequest::Held& held, double margin, const ContactModel& model, const Tries& tries) HD_RT;
  [[nodiscard]] bool isKnown(std::uint32_t k, std::uint32_t feature, const CollideRequest::Held& held,
                             const Tries& tries) const HD_RT;
  /** Whether that feature's contact with obstacle k is among the first so many found. */
  [[nodiscard]] bool isFound(std::uint32_t k, std::uint32_t feature, std::uint32_t among) const HD_RT;
  struct Purse;
  enum class Looked : std::uint8_t { kNear, kFar, kUnknown };  ///< Unknown: the work was not enough.
  /** Whether a shape is a surface that encloses nothing, and has no volume with its holes closed. */
  [[nodiscard]] bool isSheet(const Shape& shape) const HD_RT {
    return shape.kind == ShapeKind::kMesh && (shape.mesh->flags & HD_MESH_CLOSED) == 0 && volumeOf(shape) == nullptr;
  }
  /** Nearest point of an obstacle, or what its field says where that is too far. `side`, in and out: of a sheet on
   * which the point counts as outside, 1 or -1; 0: where it is. */
  Looked lookAt(const CollideRequest::Obstacle& obstacle, const Vec3& x_B, double reach, Purse& purse, int& side,
                PointTouch& out) const HD_RT;
  /** The same for disc i of a cylinder, or one beside it, from its middle, which comes to be at x_W. */
  Looked lookFromDisc(std::uint32_t i, const CollideRequest::Held& held, const CollideRequest::Obstacle& obstacle,
                      double reach, Purse& purse, int& side, Vec3& x_W, PointTouch& out) const HD_RT;
  /** What of point, ball or disc i about x_W lies lowest over a plane; false: of a disc the cylinder's end does. */
  [[nodiscard]] bool lowest(std::uint32_t i, const CollideRequest::Held& held, const Vec3& x_W, const Vec3& n_W,
                            Vec3& p_WA) const HD_RT;
  /** Whether the obstacle is where a disc is said to meet it, and not beyond the end of the cylinder. */
  [[nodiscard]] bool isThere(const Contact& contact, const CollideRequest::Held& held,
                             const CollideRequest::Obstacle& obstacle, double reach, int side,
                             Purse& purse) const HD_RT;
  /** Of a tool that is a closed mesh: whether no part of it is farther out along n than its point x, or will be when
   * it has turned so far [rad]. In its frame. */
  [[nodiscard]] bool isOutermost(const Vec3& x, const CollideRequest::Held& held, const Vec3& n, double turn,
                                 Purse& purse) const HD_RT;
  /** Whether vertex x of the tool's mesh, which an edge of the obstacle has found, is told as one of its points: where
   * the obstacle is nearest to it no part of the tool is farther in. In its frame. */
  [[nodiscard]] bool isToldAsPoint(const Vec3& x, const CollideRequest::Held& held,
                                   const CollideRequest::Obstacle& obstacle, Purse& purse) const HD_RT;
  /** Whether point i may touch obstacle k as that says, or, of what is apart, once a hit has turned the tool: what
   * strikes with one corner comes down on the next before the next answer. Else an edge of the obstacle is beside it,
   * on which it would be caught as on a notch. */
  [[nodiscard]] bool mayLean(std::uint32_t i, const CollideRequest::Held& held, std::uint32_t k, const Contact& contact,
                             Purse& purse) const HD_RT;
  /** Whether contact i is that of a cylinder's point, and of a disc, too: what is tied to that point would only brake
   * the cylinder where it rolls. */
  [[nodiscard]] bool isBesideDisc(std::uint32_t i, const CollideRequest::Held& held) const HD_RT;
  /** Whether contact i is of a disc that meets a corner, edge or rim which is told by its number, too (mantle.h). That
   * one turns from tick to tick, the disc's plane only from answer to answer: both in turn would shake the cylinder. */
  [[nodiscard]] bool isMetByMantle(std::uint32_t i) const HD_RT;
  void dropToldTwice(const CollideRequest::Held& held) HD_RT;
  /** Whether what is said to be touched of one obstacle is in or on the other, and nothing of it stands out there. */
  [[nodiscard]] bool isHidden(const Contact& contact, const CollideRequest::Obstacle& its,
                              const CollideRequest::Obstacle& other, Purse& purse) const HD_RT;
  void dropHidden(const CollideRequest::Held& held, Purse& purse) HD_RT;
  void drop(std::uint32_t i) HD_RT;
  /** False where that is not known of all obstacles. */
  bool tryPoint(std::uint32_t i, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT;
  using Walls = std::array<PointTouch, 2>;  ///< With the nearest three, which hold a ball.
  /** Of a mesh: where else a ball about x touches it within reach, in its frame; `first` leads from the nearest place
   * to x, `facing` is -1 behind a sheet. How many. */
  static std::uint32_t furtherWalls(const Shape& mesh, const Vec3& x, const Vec3& first, double facing, double reach,
                                    Purse& purse, Walls& out) HD_RT;
  /** What else of obstacle k point, ball or disc i touches, where that is a mesh: `first` is the nearest, `side`
   * lookAt()'s. */
  void tryFurtherWalls(std::uint32_t i, std::uint32_t k, const CollideRequest::Held& held, const PointTouch& first,
                       int side, double margin, Purse& purse) HD_RT;
  /** Those that touched last time, or the others, from `cursor` on, which says where it ended if the purse was empty.
   */
  void tryPoints(bool hot, std::uint32_t& cursor, Tries& tries, const CollideRequest::Held& held, double margin,
                 Purse& purse) HD_RT;
  /** The tool's surface against a sphere, a capsule, or a cylinder's mantle: what it meets between two of its points.
   * False: its points may know more, for it may be hollow, and they meet a cylinder's ends. */
  bool tryRound(std::uint32_t k, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT;
  /** The tool's surface against the edges, corners and rims of a box or cylinder: as tryRound(). */
  void tryEdges(std::uint32_t k, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT;
  /** The mantle of a cylinder or capsule against corners, edges and rims of a box or cylinder. */
  void tryMantle(std::uint32_t k, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT;
  /** Whether what is held has a mantle that meets the edge of that number (feature.h); of a rim, about `start`. */
  [[nodiscard]] static bool meetsMantle(const CollideRequest::Held& held, const CollideRequest::Obstacle& obstacle,
                                        std::uint32_t feature, const Vec3& start, double margin,
                                        Contact& contact) HD_RT;
  /** The tool's surface against ridges and peaks of a mesh, but for those of which the tool's points tell as much. */
  void tryRidges(std::uint32_t k, const CollideRequest::Held& held, Purse& purse) HD_RT;
  struct RidgeSearch;
  /** One contact for all of the tool, where that and obstacle k are deep in each other, solids both. */
  void tryWayOut(std::uint32_t k, const CollideRequest::Held& held, Purse& purse) HD_RT;
  /** Whether a point of the tool is on the side of a sheet that its triangles do not look to. */
  [[nodiscard]] bool isBehind(const CollideRequest::Obstacle& sheet) const HD_RT;
  /** Of what is found too many the deepest stay, of each side that something touches on: see keep(). */
  struct Kept {
    std::uint8_t side = 0;  ///< Obstacle and direction; kFar.
    double depth = 0;       ///< When the next answer comes, and more for one of the answer before [m].
    double reach = 0;       ///< reachOf(), at least ContactModel::kLeastReach [m].
  };
  static constexpr std::uint8_t kFar = 0;  ///< It cannot touch before the next answer.
  static constexpr std::uint32_t kSides = 1 + 6 * CollideRequest::kMostObstacles;
  /** No more of its gap closes before the next answer [m]: as far as it moves that way now, and kMargin, for another
   * touch may turn the tool. */
  [[nodiscard]] double reachOf(const Contact& contact, const CollideRequest::Held& held, std::uint32_t k) const HD_RT;
  /** As far as its gap closes until then if both go on as they move [m]. */
  [[nodiscard]] double closingOf(const Contact& contact, const CollideRequest::Held& held, std::uint32_t k) const HD_RT;
  void keep(const Contact& contact, const CollideRequest::Held& held, std::uint32_t k) HD_RT;
  /** Where a contact goes; kMaxContacts: nowhere. */
  [[nodiscard]] std::uint32_t roomFor(const Kept& kept) const HD_RT;
  void noteHeld(const CollideRequest::Held& held, const ContactModel& model) HD_RT;

  const VolumeTable* volumes_ = nullptr;
  std::uint32_t patches_;
  PointFieldDetector field_;
  ContactSet field_found_;
  std::array<Stood, CollideRequest::kMostObstacles + 1> last_{};  ///< The tool and the obstacles, last time.
  std::uint32_t last_count_ = 0;
  std::uint32_t whole_ = 0;  ///< Bit k: obstacle k has been asked by its field or its balls, not by points.
  std::uint32_t cut_ = 0;    ///< Bit k: there was no time for all of it.

  ToolPoints points_;
  std::uint32_t made_for_ = 0;
  Shape made_of_;
  std::array<bool, ToolPoints::kMost> hot_{};
  std::array<float, ToolPoints::kMost> depth_{};  ///< Of each point, when it was last tried [m].
  /** Of the sheet that a point is near to. */
  struct Sided {
    std::uint32_t slot = 0;
    int side = 0;
    bool in = false;  ///< It has gone through.
  };
  /** Whether a point of the tool, at x_A, has come to the other side of a sheet, from where `up` leads to (in its
   * frame), over its border, or within kInset of that, and not through it. */
  [[nodiscard]] bool hasGoneRound(const Vec3& x_A, const CollideRequest::Held& held,
                                  const CollideRequest::Obstacle& sheet, const Vec3& up, Purse& purse) const HD_RT;
  std::array<Sided, ToolPoints::kMost> side_{};
  std::uint32_t cursor_ = 0, hot_cursor_ = 0;  ///< Where the budget ended last time.
  /** Of a box: its corners are kept before all others, and few are enough. */
  static constexpr std::uint32_t kBoxRoom = 64;
  std::uint32_t room_ = kMaxContacts;  ///< For contacts.
  ContactSet found_;
  std::array<std::uint8_t, kMaxContacts> body_of_{};
  std::array<Kept, kMaxContacts> kept_{};
  std::array<std::uint8_t, kSides> many_{};  ///< Of those kept.
  double ahead_ = 0;                         ///< Until the next answer [s].
  double reach_ = 0;                         ///< No gap closes by more before the next answer [m].
  /** What the answer before held. */
  struct Named {
    std::uint32_t body = 0, feature = 0;
  };
  std::array<Named, kMaxTouches> named_{};
  std::uint32_t named_count_ = 0;
};

}  // namespace hapticd
