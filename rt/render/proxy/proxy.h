/** @file
 * 3-DOF rendering by a proxy (god-object: Zilles and Salisbury, IROS 1995; proxy: Ruspini, Kolarov, Khatib, SIGGRAPH
 * 1997) with the thesis's two-state friction cone (section 2.2.1). docs/rendering.md tells the method.
 */
#pragma once

#include <array>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "rt/base/math.h"
#include "rt/geometry/half_spaces.h"
#include "rt/geometry/sweep/sweep.h"
#include "rt/render/proxy/surroundings.h"
#include "rt/scene/scene.h"

namespace hapticd {

inline constexpr int kMaxHolding = 3;  ///< At once: four planes meet in no point.

/** What one of several objects that hold a proxy has of the contact. */
struct ContactPart {
  std::uint32_t object = 0;   ///< Id.
  Vec3 point = Vec3::Zero();  ///< Of contact, in W [m].
  Vec3 force = Vec3::Zero();  ///< Of its spring on the hand, in W [N].
  double share = 0;           ///< Of friction, damping and what is added: from 0 to 1, in the sum 1.
};

/** Coefficients of friction. */
struct Friction {
  double still = 0, sliding = 0;
};

/** A moment about the contact's normal that the same friction bears: of a soft finger (rt/finger/soft_finger.h). */
struct TwistLoad {
  double moment = 0;  ///< [N m]; 0: friction is the proxy's alone.
  double arm = 0;     ///< Friction mu P bears mu P arm alone [m].
};

/** Contact of one device point. Vectors in W. */
struct SurfaceContact {
  Vec3 force = Vec3::Zero();  ///< On the hand [N].
  Vec3 proxy = Vec3::Zero();  ///< Centre of the ball, or point on the surface; the hip in free space [m].
  Vec3 point = Vec3::Zero();  ///< Of contact, on the surface; the proxy in free space [m].
  /** Outward, unit; zero in free space. Where objects of different stiffness hold the proxy, turned to the stiffer. */
  Vec3 normal = Vec3::Zero();
  Vec3 smooth = Vec3::Zero();    ///< The same of the surface that a shaded mesh stands for (Shading); else `normal`.
  Vec3 velocity = Vec3::Zero();  ///< Of the surface at `point` [m/s],
  Vec3 at_hip = Vec3::Zero();    ///< and of what is fixed to it where the hip is: a hand that goes so rests on it.
  double depth = 0;              ///< Of the hip below where the proxy may be, along the normal [m].
  double stiffness = 0;          ///< Of all that holds the proxy: the elastic force is that times `pull` [N/m].
  Vec3 pull = Vec3::Zero();      ///< Depth * normal, and across it what friction keeps back [m].
  double stored = 0;             ///< Energy in the springs [J].
  double damping = 0;            ///< Part of the force that the material's damping makes, along the normal [N].
  double damping_gain = 0;       ///< By which it is made [N s/m].
  Friction friction;             ///< Of all that holds the proxy.
  /** What what moves gives the hand beyond force * velocity, by axis: by turning, and of several objects apart [W]. */
  Vec3 apart = Vec3::Zero();
  std::uint32_t object = 0;  ///< Id of the object in contact, 0 for none: of several, that which it touched first.
  std::array<ContactPart, kMaxHolding> part;
  std::uint32_t parts = 0;  ///< Surfaces of several objects that hold the proxy; 0 where one object does.
  bool slip = false;
  bool touch = false;  ///< Contact began this tick.
  /** Tree nodes, triangles and primitives visited: bounded, see kMaxWork; what Surroundings visits comes on top. */
  std::uint32_t work = 0;
};

/** One of the surfaces that hold a proxy. */
struct HoldingSurface {
  std::uint32_t object = 0;   ///< Id.
  std::uint32_t feature = 0;  ///< As in SweepHit, with kind and corner.
  FeatureKind kind = FeatureKind::kFace;
  std::uint32_t corner = 0;
  Vec3 normal = Vec3::Zero();  ///< Outward, unit, in W.
  double push = 0;             ///< The sum of push * normal leads from the hip to where all of them let it be [m].
};

/** What a step looked at: where its time went. */
struct ProxyEffort {
  std::uint32_t sweeps = 0;
  std::uint32_t visited = 0;   ///< Nodes, triangles and primitives, for sweeps and looks.
  std::uint32_t gathered = 0;  ///< The same, for what is kept from tick to tick.
  std::uint32_t turns = 0;     ///< Of the tangent planes of grooves and corners.
  std::uint32_t walked = 0;    ///< Faces of meshes followed from one to the next; among `visited`.
};

/**
 * Proxy of one device point: a point, or a ball of some radius about it. Servo thread only; deterministic.
 *
 * The proxy moves only along swept segments that are free, and so never enters a solid from outside. It is kept a skin
 * above the surfaces it touches: 2^-40 of the coordinates involved, about 8000 times their rounding; forces are
 * computed from the surface itself, without the skin.
 */
class ProxyRenderer {
 public:
  /** Most nodes, triangles and primitives one step visits. Beyond it the proxy stays: late, never on a wrong side. */
  static constexpr std::uint32_t kMaxWork = 50'000;
  /** Most segments one step sweeps. */
  static constexpr std::uint32_t kMaxSweeps = 64;
  /** Faces that walks of one step look at before it begins no other: four long ones, or many short ones. */
  static constexpr std::uint32_t kMaxWalked = 128;

  /** Largest ball [m]. */
  static constexpr double kMaxRadius = 0.1;

  /** Starts anew with the proxy at the hip. */
  void reset(const Vec3& hip_W) HD_RT;

  /**
   * Radius of the ball [m]; 0, as at the start, for a point. Taken on as far as there is room, at once in free space,
   * else tick by tick: a ball that grows pushes nobody. Not finite or negative counts as 0.
   */
  void setRadius(double radius) HD_RT { wanted_radius_ = std::isfinite(radius) && radius > 0 ? radius : 0; }
  /**
   * Steps in which the hip's coordinates come [m], as a device's encoders give them: what slips does not stick for one
   * of them. Not positive counts as 0, as at the start.
   */
  void setResolution(double step) HD_RT { resolution_ = step; }
  /** What surfaces damp by at most [N s/m]; as at the start, by what they are told. */
  void setMaxDamping(double b) HD_RT { max_damping_ = b; }
  /** For the next step: what of friction is asked for by a twist. */
  void bear(const TwistLoad& load) HD_RT { load_ = load; }
  /** Whether triangles are kept from tick to tick. It changes no force, only what it costs;
   * for tests and benchmarks.
   */
  void keepSurroundings(bool keep) HD_RT { keep_ = keep; }
  /** Of the last step. */
  [[nodiscard]] const ProxyEffort& effort() const HD_RT { return effort_; }
  [[nodiscard]] const Surroundings& surroundings() const HD_RT { return surroundings_; }
  /** What held the proxy at the end of the last step; none, where no object of these is shaded, rings or has a relief.
   */
  [[nodiscard]] std::span<const HoldingSurface> holding() const HD_RT {
    return {holding_.data(), static_cast<std::size_t>(holding_count_)};
  }
  /** As set [m]. */
  [[nodiscard]] double radius() const HD_RT { return wanted_radius_; }

  /**
   * Moves the proxy toward `hip_W`, or around an edge to a nearer part of the surface, and computes the force
   * k (proxy - hip) plus damping against the relative velocity of hip and surface along the normal (never pulling).
   * Objects' motion since the last tick is swept. A hip that is not finite gives no force, and the next step starts
   * anew.
   */
  void step(const Scene& scene, const Vec3& hip_W, const Vec3& v_W, double dt, SurfaceContact& contact) HD_RT;

 private:
  /** A surface that holds the proxy in this step. */
  struct Constraint {
    std::uint32_t slot = 0;
    std::uint32_t feature = 0;
    FeatureKind kind = FeatureKind::kFace;
    std::uint32_t corner = 0;   ///< As in SweepHit.
    Vec3 point = Vec3::Zero();  ///< Of contact, in the object's frame.
    HalfSpace surface;          ///< What holds the proxy: tangent plane, a radius out, in W at this tick's pose.
    double skin = 0;            ///< The proxy stays this far above it.
  };
  /** A face of a mesh and its plane, in the object's frame. */
  struct MeshPlane {
    std::uint32_t triangle = 0;
    HalfSpace plane;
  };
  /** What is swept next: a way of several parts, without a new look at the surfaces where they meet. */
  struct Plan {
    Vec3 way[2];
    Vec3 above[2];  ///< Of each part, the normal of a surface along which it leads; zero if there is none.
    int parts = 0, gone = 0;
    bool in_groove = false;  ///< The way leads through the air above a groove.
    bool stay = false;       ///< The proxy is where it belongs.
    /** At the end of the way, if it is free, the proxy is where it belongs, held by the faces below; if there are none,
     * by these of Step::held, by bit: surfaces that hold it now, or what was noted behind them: their tangent planes
     * there, or the faces to which their edges lead. */
    bool lands = false;
    std::uint32_t keeps = 0;
    std::uint32_t slot = 0;
    int faces = 0;
    MeshPlane face[2];

    [[nodiscard]] const Vec3& target() const HD_RT { return way[gone]; }
    void goTo(const Vec3& x) HD_RT {
      way[0] = x;
      above[0].setZero();
      parts = 1;
      gone = 0;
      in_groove = stay = lands = false;
      faces = 0;
    }
  };
  /** What keeps the proxy from the hip, exactly on the surfaces. In W. */
  struct Support {
    Vec3 at = Vec3::Zero();    ///< The proxy.
    Vec3 foot = Vec3::Zero();  ///< Where it would be without friction; the depth is counted from here.
    std::uint32_t active = 0;  ///< Which of the surfaces held, by bit.
    bool touching = false;
  };
  /** What held the proxy where a step left it, and what must be the same for it to hold it still. */
  struct Rest {
    struct Surface {
      Constraint held;
      std::uint32_t id = 0;  ///< Of the object.
      std::uint32_t flags = 0;
      std::uint64_t number = 0, moves = 0;  ///< Shape::number and those of its mesh's vertices.
    };
    Surface on[kMaxHalfSpaces];
    int count = 0;
    double radius = 0;  ///< Of the ball.
  };
  /** Where the proxy lies on a mesh that may deform: if it rubs, that place of the surface takes it along. */
  struct Footing {
    std::uint32_t object = 0;  ///< Id, 0 if there is none,
    std::uint64_t number = 0;  ///< and its Shape::number.
    std::uint32_t triangle = 0;
    double weight[3] = {};  ///< Of its corners, in the sum 1.
    bool rubs = false;
    int side = 0;  ///< As MetFrom::on.
  };
  /** What all that holds the proxy does to the hand. */
  struct Press {
    Vec3 normal = Vec3::Zero();  ///< Of the force without friction.
    Vec3 turned = Vec3::Zero();  ///< Depth * normal - up [m].
    double stiffness = 0;        ///< That force for each metre of depth [N/m].
    double stored = 0;           ///< Twice the energy in its springs for the square of one [N/m].
    double damping = 0;          ///< [N s/m].
    Vec3 velocity = Vec3::Zero();
    Vec3 at_hip = Vec3::Zero();
    Vec3 apart = Vec3::Zero();  ///< As in SurfaceContact, but for what one object gives.
  };
  /** A place of the surface that is nearer to the hip than the one that holds the proxy. In W. */
  struct Nearer {
    std::uint32_t slot = 0;      ///< 0: there is none.
    Vec3 point = Vec3::Zero();   ///< Of the surface.
    Vec3 normal = Vec3::Zero();  ///< From it to the ball's centre.
    double depth = 0;            ///< Of the hip below where the centre would be [m].
    double above = 0;            ///< How far the ball comes down above it, before it settles [m].
  };
  struct Step;
  /** What a sweep passes: nothing, what holds the proxy but for other faces of its meshes, all but these, or all that
   * holds it. */
  enum class Beside : std::uint8_t { kNone, kHolding, kAllButFaces, kHolders };
  /** Of a ball that stays where it is, held by the same surfaces: whether no other face of their meshes is there. */
  struct Looked {
    int count = 0;  ///< Surfaces that held it then; 0: not looked.
    Vec3 at = Vec3::Zero();
    bool alone = false;
  };

  static constexpr int kMaxInGroove = 3;                          ///< Surfaces that are looked at together.
  static constexpr std::uint32_t kKeptSweeps = kMaxInGroove + 1;  ///< Of a step, for holdWhereItIs().

  void begin(Step& step) HD_RT;
  [[nodiscard]] bool mayCarry(const Step& step, const SceneObject& object) const HD_RT;
  void noteStarts(const Step& step) HD_RT;
  void followVertices(Step& step) HD_RT;
  void noteFooting(const Step& step, std::uint32_t active, const Friction& friction) HD_RT;
  [[nodiscard]] bool isBehind(const SceneObject& object, std::uint32_t slot) const HD_RT;
  void makeRoom(Step& step) HD_RT;
  void pushOut(Step& step, std::uint32_t slot) HD_RT;
  bool stepOff(Step& step, bool unstuck = false) HD_RT;
  void fitRadius(Step& step) HD_RT;
  void settle(Step& step) HD_RT;
  void settleNearer(Step& step) HD_RT;
  void settleCarried(Step& step) HD_RT;
  void settleAgain(Step& step, const Vec3& from, std::uint32_t slot) HD_RT;
  /** How far from the hip what moves may take the proxy in one tick, and where it stays if that would be farther. */
  struct Pinch {
    double most = std::numeric_limits<double>::infinity();  ///< [m]
    Vec3 from = Vec3::Zero();
    std::uint32_t by = 0;  ///< Slot of what holds it there.
    double near = 0;       ///< What is nearer to that place closes on it [m].
  };
  [[nodiscard]] double wayOf(const Step& step, std::uint32_t slot) const HD_RT;
  Pinch pinchOf(const Step& step) HD_RT;
  [[nodiscard]] bool isUnderBody(Step& step, const Pinch& pinch) const HD_RT;
  [[nodiscard]] std::uint32_t pressedOfTwo(const Step& step, const Vec3& from) const HD_RT;
  void leavePinch(Step& step, const Pinch& pinch) HD_RT;
  [[nodiscard]] bool goBack(Step& step, const Vec3& from, std::uint32_t slot) HD_RT;
  bool sweepTo(Step& step, const Vec3& target, const Vec3& above, bool& hit, std::uint32_t& slot, SweepHit& first,
               Beside beside = Beside::kNone) HD_RT;
  [[nodiscard]] bool isBesideNoFace(Step& step) const HD_RT;
  bool meetBeside(Step& step) HD_RT;
  void moveBy(Step& step, const Vec3& target, double t) HD_RT;
  void comeTo(Step& step, const Vec3& target, std::uint32_t slot, const SweepHit& first) HD_RT;
  void arrive(Step& step, const Vec3& target) HD_RT;
  void meet(Step& step, const Vec3& target, std::uint32_t slot, const SweepHit& first) HD_RT;
  void hold(Step& step, std::uint32_t slot, const SweepHit& hit) HD_RT;
  void noteRest(const Step& step, std::uint32_t active) HD_RT;
  int holders(const Step& step, std::uint32_t active, const Vec3& up, HoldingSurface* out) const HD_RT;
  void noteHolding(const Step& step, std::uint32_t active, const Vec3& up) HD_RT;
  [[nodiscard]] Friction frictionOf(const Step& step, const SceneObject& object, std::uint32_t active,
                                    const Vec3& up) const HD_RT;
  [[nodiscard]] Press pressOf(const Step& step, const SceneObject& object, std::uint32_t feature, std::uint32_t active,
                              const Vec3& up, const Vec3& x, SurfaceContact* contact = nullptr) const HD_RT;
  void shareFriction(Step& step, double k, double r, double d, Friction& friction) const HD_RT;
  bool holdAgain(Step& step) HD_RT;
  void holdWhereItIs(Step& step) HD_RT;
  [[nodiscard]] bool slideOnCurve(Step& step, const Vec3& at, double friction, double rest, Plan& plan) const HD_RT;
  void plan(Step& step, Plan& plan) HD_RT;
  [[nodiscard]] static bool isOnEdge(const SceneObject& object, const Constraint& c, const Vec3& x) HD_RT;
  [[nodiscard]] static bool isOnFeature(const SceneObject& object, const Constraint& c, const Vec3& x) HD_RT;
  [[nodiscard]] bool planOnCurve(Step& step, const Vec3& here, Plan& plan) HD_RT;
  [[nodiscard]] static int sidesOf(const Step& step, Constraint (&side)[kMaxInGroove]) HD_RT;
  [[nodiscard]] bool walkBelow(const SceneObject& object, const Constraint& c, const Vec3& x,
                               Constraint& there) const HD_RT;
  [[nodiscard]] bool sideAt(const SceneObject& object, const Constraint& c, const Vec3& x,
                            Constraint& there) const HD_RT;
  [[nodiscard]] double curvatureAlong(const SceneObject& object, const Constraint& c, const Vec3& e) const HD_RT;
  [[nodiscard]] double shareLeft(const Step& step, const Constraint* side, const HalfSpace* planes, std::uint32_t keeps,
                                 const Vec3& next, Vec3& way) const HD_RT;
  [[nodiscard]] bool planInGroove(Step& step, const Vec3& here, double friction, double rest, Plan& plan) HD_RT;
  [[nodiscard]] double depthAtRest(Step& step, int i) const HD_RT;
  bool followFaces(Step& step, int held, const Vec3& at_W, double friction, const Vec3& eased, Plan& plan) const HD_RT;
  void land(Step& step, const Plan& plan) HD_RT;
  void holdFace(Step& step, std::uint32_t slot, const MeshPlane& face) HD_RT;
  [[nodiscard]] bool tangentTo(const SceneObject& object, const Constraint& c, const Vec3& x,
                               Constraint& there) const HD_RT;
  [[nodiscard]] bool tangentIn(const SceneObject& object, Constraint& c, const Vec3& x, Vec3& normal,
                               double& offset) const HD_RT;
  const Support& support(Step& step) const HD_RT;
  [[nodiscard]] double spread(const Step& step) const HD_RT;
  bool letGoOfAbsent(Step& step, double& last) const HD_RT;
  bool leaveVertex(Step& step) HD_RT;
  bool goAround(Step& step) HD_RT;
  void goToward(Step& step, const Vec3& target) HD_RT;
  bool nearerOn(Step& step, const Support& now, std::uint32_t slot, int i, Nearer& best) const HD_RT;
  [[nodiscard]] bool isWithin(Step& step, std::uint32_t slot) const HD_RT;
  [[nodiscard]] bool isAbout(Step& step, std::uint32_t slot) const HD_RT;
  bool goAroundTo(Step& step, const Support& now, const Nearer& nearer) HD_RT;
  [[nodiscard]] static bool touchesHeld(const Step& step, std::uint32_t slot, const Vec3& x, double radius) HD_RT;
  bool goVia(Step& step, const Vec3* way, int count, double most) HD_RT;
  void finish(Step& step, const Vec3& v_W, SurfaceContact& contact) HD_RT;
  [[nodiscard]] int foremost(const Step& step, std::uint32_t active) const HD_RT;
  [[nodiscard]] bool isReshaped(const Step& step) const HD_RT;
  void followShape(Step& step) HD_RT;
  Vicinity* vicinityOf(Step& step, std::uint32_t slot, const Vec3& start) HD_RT;
  [[nodiscard]] Vec3 startIn(const Step& step, std::uint32_t slot) const HD_RT;
  [[nodiscard]] Vec3 here(const Step& step) const HD_RT;

  Vec3 proxy_ = Vec3::Zero();
  double radius_ = 0;  ///< Of the ball, at most as wanted.
  double wanted_radius_ = 0;
  std::uint32_t object_ = 0;  ///< Id of the object in contact, 0 in free space,
  std::uint64_t shape_ = 0;   ///< and which of its shapes that was.
  bool slip_ = false;
  /** Where the proxy was left: its way from where it would be without friction, in depths. */
  double left_ = 0;
  double resolution_ = 0;                                         ///< Of the hip [m].
  double max_damping_ = std::numeric_limits<double>::infinity();  ///< [N s/m]
  TwistLoad load_;
  std::uint32_t hint_slot_ = 0;  ///< Where the last triangle was met: likely the next one too.
  std::uint32_t hint_ = HD_NO_INDEX;
  bool started_ = false;
  bool keep_ = true;
  std::uint64_t arrivals_ = 0;                                    ///< Of the scene, as in the last step.
  std::bitset<kMaxObjects> about_ = ~std::bitset<kMaxObjects>();  ///< Slots of what may have appeared about its centre.
  Surroundings surroundings_;
  Rest rest_;
  Looked looked_;
  Footing footing_;
  std::array<HoldingSurface, kMaxHolding> holding_;
  int holding_count_ = 0;
  ProxyEffort effort_;

  /**
   * Where a step ends before the proxy stands at one place relative to all moving objects (squeezed, or out of work),
   * the places in each object's frame are kept and swept on from in the next tick.
   */
  bool behind_ = false;
  std::array<Vec3, kMaxObjects> start_{};              ///< By slot, in the object's frame.
  std::array<std::uint32_t, kMaxObjects> start_id_{};  ///< Which object that was, 0 if it could not be touched,
  std::array<Pose, kMaxObjects> start_pose_{};         ///< and where it stood.
  std::uint32_t pinched_by_ = 0;                       ///< Object that holds a pinched proxy where it is; 0: none.
  std::array<Vec3, kMaxObjects> carried_{};            ///< As start_, before the proxy settles.
};

}  // namespace hapticd
