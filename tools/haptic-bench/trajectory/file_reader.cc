#include "tools/haptic-bench/trajectory/file_reader.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "proto/shm_layout.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/tree_nearest.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/trajectory/fit.h"

namespace haptic_bench {
namespace {

/** Three columns. */
struct Vectors {
  Table::Column x, y, z;
  explicit operator bool() const { return static_cast<bool>(x); }
  [[nodiscard]] Vec3 operator[](std::size_t row) const { return {x[row], y[row], z[row]}; }
};

/** All three by the pattern's names, {} the axis; none; or Failure for one or two of them. */
Vectors findVectors(const Table& table, const char* pattern, bool needed) {
  const auto name = [&](char axis) { return fmt::format(fmt::runtime(pattern), axis); };
  Vectors v{table.find(name('x')), table.find(name('y')), table.find(name('z'))};
  if (!needed && !v.x && !v.y && !v.z) return v;
  return {table.need(name('x')), table.need(name('y')), table.need(name('z'))};
}

/** Which rows hold the truth: all, but where columns of --samples, hapticctl monitor or an export say otherwise. */
class JudgedRows {
 public:
  explicit JudgedRows(const Table& table) : judged_(table.find("judged")), armed_(table.find("armed")) {
    if (armed_) {
      flags_ = table.find("flags");
      return;
    }
    ramping_ = table.find("ramping");
    if (ramping_) armed_ = table.find("enabled");
  }
  bool operator[](std::size_t row) const {
    if (judged_) return judged_[row] != 0;
    const bool ramping = (flags_ && std::fmod(std::floor(flags_[row] / double{HD_SAMPLE_RAMPING}), 2) == 1) ||
                         (ramping_ && ramping_[row] != 0);
    return !armed_ || (armed_[row] != 0 && !ramping);
  }
  /** The file says itself which. */
  [[nodiscard]] bool told() const { return static_cast<bool>(judged_); }

 private:
  Table::Column judged_, armed_, flags_, ramping_;
};

Trajectory readOut(const Table& table, const std::vector<double>& t_s, const Vectors& p, const Model& model,
                   const Surface& surface) {
  const Vectors n = findVectors(table, "n{0}", false), f = findVectors(table, "f{0}", false);
  const Table::Column fn = f ? table.find("fn") : table.need("fn");
  const TreeNearest nearest(model);
  double squares = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double off = nearest.find(p[i]).distance;
    squares += off * off;
  }
  requireNear(
      model, std::sqrt(squares / static_cast<double>(table.rows())), table.where() + ": its positions",
      "in the model's frame and metres: see the columns' units, scale of the model, and its x, y, z, turn_x ...");
  std::vector<SurfaceSample> out;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    SurfaceSample s{t_s[i], p[i], n ? n[i] : nearest.find(p[i]).normal, 0};
    if (std::abs(s.normal.norm() - 1) > 0.01) {
      throw Failure(table.at(i), fmt::format("the normal has length {:.4g}", s.normal.norm()), "unit normals");
    }
    s.normal.normalize();
    checkForce(table, i, fn ? Vec3(fn[i], 0, 0) : f[i]);
    s.force = std::max(0.0, fn ? fn[i] : f[i].dot(s.normal));
    out.push_back(s);
  }
  if (std::none_of(out.begin(), out.end(), [](const SurfaceSample& s) { return s.force > 0; })) {
    throw Failure(table.where(), "no force in it presses on the surface",
                  "forces on the hand, outward: change the sign, or the columns");
  }
  Trajectory in = pressInto(out, surface);
  judgeWhereItFits(in, out, model, surface.radius, table.where());
  tellOfThinPlaces(in, out, model, table.where());
  return in;
}

}  // namespace

void addFileOptions(CLI::App& sub, FileOptions& options) {
  sub.add_option("--columns", options.columns, "Names of a file's columns, as t,x,y,z,-,fn (- is passed over)");
  sub.add_flag("--out", options.out, "The file's positions are on the surface: an out-trajectory");
  sub.add_option("--rate", options.rate_hz, "Samples a second of a file without times [Hz]")->check(positive());
  sub.add_option("--device", options.device, "Device of a recording or its CSV, from 0")
      ->capture_default_str()
      ->check(within(0, 63))
      ->transform(hapticd_options::decimal);
  sub.add_option("--max-gap", options.max_gap_s, "Longest step of a file's times [s]")->check(positive());
}

Trajectory readColumns(Table table, const FileOptions& options, const Model& model, const Surface& surface) {
  if (options.device > 0 && !table.find("device")) {
    throw Failure("--device", "it does nothing for " + table.where() + ", which has no column device",
                  "it is for files of several devices");
  }
  table.keepOnly("device", options.device);
  if (table.holds("enabled")) {  // An export. Where the device failed the hand is nowhere, as in the recording.
    for (const char* position : {"px", "py", "pz"}) table.leaveOutUnknown(position);
  }
  const std::vector<double> t_s = readTimes(table, options.rate_hz, options.max_gap_s);
  const Vectors p = findVectors(table, "{0} p{0} hip_{0}", true);
  for (std::size_t i = 0; i < table.rows(); ++i) checkPosition(table, i, p[i]);
  const JudgedRows judged(table);
  if (options.out) {
    Trajectory pressed = readOut(table, t_s, p, model, surface);
    for (std::size_t i = 0; i < table.rows(); ++i) pressed.samples[i].judged &= judged[i];
    pressed.own_judgement = judged.told();
    pressed.start = outside(pressed.start, model, surface.radius);
    return pressed;
  }
  const Vectors proxy = findVectors(table, "proxy_{0}", false), force = findVectors(table, "f{0}", false);
  Trajectory in;
  in.proxy_known = static_cast<bool>(proxy);
  in.force_known = static_cast<bool>(force);
  in.own_judgement = judged.told();
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (force) checkForce(table, i, force[i]);
    in.samples.push_back(
        {t_s[i], p[i], proxy ? proxy[i] : Vec3(Vec3::Zero()), force ? force[i] : Vec3(Vec3::Zero()), judged[i]});
  }
  const Sample& first = in.samples.front();
  constexpr double kOffSurface = 1e-9;  // [m]: rounding, as a file holds it.
  const bool free = in.proxy_known && (first.proxy - first.hip).norm() < kOffSurface;
  in.start = free ? first.hip : outside(first.hip, model, surface.radius);
  return in;
}

Vec3 outside(const Vec3& x, const Model& model, double radius) {
  const SurfacePoint at = NearestPoint(model).find(x);
  const double above = (at.inside ? -at.distance : at.distance) - radius;
  return above < 0 ? Vec3(x - 2 * above * at.outward(x)) : x;
}

}  // namespace haptic_bench
