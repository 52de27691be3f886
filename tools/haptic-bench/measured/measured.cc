#include "tools/haptic-bench/measured/measured.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/measured/guesses.h"
#include "tools/haptic-bench/tell.h"

namespace haptic_bench {

Measured onSurface(const Recording& recording, const MeasuredOptions& options, const Model& model) {
  Measured measured;
  measured.clock_s = options.clock_s;
  const std::vector<ProbeSample> merged = merge(recording, options.merge, &measured.load);
  measured.pose_step_s =
      (recording.poses.back().t_s - recording.poses.front().t_s) / static_cast<double>(recording.poses.size() - 1);
  if (options.merge.free_s > 0) measured.lag = estimateLag(recording, freeUntil(recording, options.merge.free_s));
  const auto touches = [&](const ProbeSample& s) { return s.force_O.norm() > options.contact_force; };
  const auto first = std::find_if(merged.begin(), merged.end(), touches);
  const auto last = std::find_if(merged.rbegin(), merged.rend(), touches).base();
  if (first == merged.end())
    throw Failure("recording", "nothing is touched in it", "a smaller contact, or another free time");
  const TreeNearest surface(model);
  measured.contacts = static_cast<int>(std::count_if(first, last, touches));
  measured.registration.X_MO = options.first_guess;
  if (!options.registered) {
    std::vector<Vec3> touching, points;
    for (auto s = first; s != last; ++s) {
      if (touches(*s)) touching.push_back(s->tip_O);
    }
    const std::size_t every = std::max<std::size_t>(1, touching.size() / static_cast<std::size_t>(options.points));
    for (std::size_t i = 0; i < touching.size(); i += every) points.push_back(touching[i]);
    measured.points = static_cast<int>(points.size());
    measured.registration = registerFromSeveral(surface, boxOf(model), points, options.tip_radius, options.first_guess);
    requireNear(model, measured.registration.rms, "recording: its contacts",
                "see scale of the mesh, tip_x, tip_y and tip_z, the order of the quaternion, and the first guess");
  }
  const Pose& X_MO = measured.registration.X_MO;
  double outward = 0, squares = 0;
  for (auto s = first; s != last; ++s) {
    const Vec3 tip = X_MO * s->tip_O, force = touches(*s) ? X_MO.q * s->force_O : Vec3(Vec3::Zero());
    const SurfacePoint at = surface.find(tip);
    const Vec3 normal = at.outward(tip);
    const double off = (at.inside ? -at.distance : at.distance) - options.tip_radius;
    if (touches(*s)) squares += off * off;
    outward += force.dot(normal);
    measured.out.push_back(
        {s->t_s - first->t_s, tip - options.tip_radius * normal, normal, std::max(0.0, force.dot(normal))});
  }
  if (options.registered) {
    requireNear(model, std::sqrt(squares / measured.contacts), "recording: its contacts",
                "see x, y, z and turn_x ..., which registered=1 takes as they are, and scale of the mesh");
  }
  if (outward <= 0) {
    throw Failure("recording", "its forces pull the probe into the surface",
                  "forces on the probe, outward: change their sign, or see the pose's frames");
  }
  return measured;
}

std::string describe(const Measured& measured) {
  const Vec3& bias = measured.load.bias_S;
  std::string text =
      fmt::format("bias ({:.4g}, {:.4g}, {:.4g}) N, weight {:.4g} N; {} of {} samples in contact", bias.x(), bias.y(),
                  bias.z(), measured.load.weight, measured.contacts, measured.out.size());
  // Beyond chance, and beyond what a pose between two others may be off.
  constexpr double kSure = 5, kMatters = 0.1;
  const double lag = measured.lag.lag_s;
  if (measured.lag.deviation_s > 0 && std::abs(lag) > kSure * measured.lag.deviation_s &&
      std::abs(lag) > kMatters * measured.pose_step_s) {
    text += fmt::format("; the poses seem {:.3g} ms {} (try clock={:.6f})", 1000 * std::abs(lag),
                        lag > 0 ? "late" : "early", measured.clock_s - lag);
  }
  const Registration& r = measured.registration;
  if (measured.points == 0) return text + ", not registered";
  std::string doubts;
  if (r.guess_lost) {
    doubts = r.guess_most > 0
                 ? fmt::format("; not from the first guess, which leads to a place {:.3g} times as far off: look at it",
                               r.guess_most / r.most)
                 : "; not from the first guess, from which it does not settle: look at it";
  }
  if (r.as_near > 0) doubts += fmt::format("; as near in {} other places at least: the first guess decides", r.as_near);
  const Vec3& at = r.X_MO.p;
  const Eigen::AngleAxisd turn(r.X_MO.q);
  const Vec3 turned = turn.angle() * turn.axis();
  return text + fmt::format(
                    "; {} registered: {:.3g} mm rms off the surface, {} left out, {} of 6 freedoms determined{}; found "
                    "x={:.8g},y={:.8g},z={:.8g},turn_x={:.8g},turn_y={:.8g},turn_z={:.8g}",
                    measured.points - r.left_out, 1000 * r.rms, r.left_out, r.freedoms, doubts, at.x(), at.y(), at.z(),
                    turned.x(), turned.y(), turned.z());
}

std::vector<SurfaceSample> readMeasured(Spec& spec, const Model& model) {
  const std::string forces = spec.word("forces", ""), poses = spec.word("poses", "");
  if (forces.empty() || poses.empty()) {
    throw Failure(spec.text(), "it needs both streams", "measured:forces=F.csv,poses=P.csv");
  }
  MeasuredOptions options;
  options.merge.rate_hz = spec.number("rate", 1000, 1, 1e5);
  options.merge.tip_S = {spec.number("tip_x", 0, -1, 1), spec.number("tip_y", 0, -1, 1),
                         spec.number("tip_z", 0, -1, 1)};
  options.merge.free_s = spec.number("free", 0, 0, 3600);
  options.merge.load.weight = spec.number("weight", 0, 0, 100);
  if (options.merge.free_s > 0 && spec.has("weight")) {
    throw Failure(spec.text() + ", weight", "it is found in the free time", "leave out weight or free");
  }
  options.tip_radius = spec.number("tip_radius", 0, 0, 0.1);
  options.contact_force = spec.number("contact", 0.05, 0, 100);
  options.registered = spec.count("registered", 0, 0, 1) != 0;
  options.points = spec.count("points", 400, 6, 100000);
  options.first_guess = placement(spec);
  const double max_gap_s = spec.number("max_gap", 0, 0, 3600);
  Recording recording = readRecording(forces, poses, max_gap_s);
  options.clock_s = spec.number("clock", 0, -1e10, 1e10);
  for (PoseSample& pose : recording.poses) pose.t_s += options.clock_s;
  Measured measured = onSurface(recording, options, model);
  tellOnce("measured: " + describe(measured));
  return std::move(measured.out);
}

}  // namespace haptic_bench
