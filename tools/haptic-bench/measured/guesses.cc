#include "tools/haptic-bench/measured/guesses.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

/** The 24 turns that bring a cube's axes to its axes; the first is none. */
std::vector<Eigen::Quaterniond> turnsOfACube() {
  std::vector<Eigen::Quaterniond> turns;
  for (int first = 0; first < 6; ++first) {
    for (int second = 0; second < 6; ++second) {
      if (first % 3 == second % 3) continue;
      Eigen::Matrix3d R;
      R.col(0) = (first < 3 ? 1 : -1) * Vec3::Unit(first % 3);
      R.col(1) = (second < 3 ? 1 : -1) * Vec3::Unit(second % 3);
      R.col(2) = R.col(0).cross(R.col(1));
      turns.emplace_back(R);
    }
  }
  return turns;
}

/** See registerFromSeveral(). */
std::vector<Pose> guessesAbout(const Pose& X_MO, const Eigen::AlignedBox3d& points, const Eigen::AlignedBox3d& mesh) {
  std::vector<Pose> all;
  const Vec3 middle_O = points.center(), middle_M = X_MO * middle_O;
  const auto add = [&](const Eigen::Quaterniond& turn, const Vec3& to) {
    const Eigen::Quaterniond q = turn * X_MO.q;
    all.push_back({to - q * middle_O, q});
  };
  for (const Eigen::Quaterniond& turn : turnsOfACube()) {
    if (!all.empty()) add(turn, middle_M);
    add(turn, mesh.center());
  }
  constexpr double kShift = 0.25;  // Of the extent.
  for (int axis = 0; axis < 6; ++axis) {
    const double shift = (axis < 3 ? kShift : -kShift) * points.diagonal().norm();
    add(Eigen::Quaterniond::Identity(), middle_M + shift * Vec3::Unit(axis % 3));
  }
  return all;
}

/** Every so manieth point. */
std::vector<Vec3> fewOf(const std::vector<Vec3>& points) {
  constexpr std::size_t kFew = 100;
  std::vector<Vec3> few;
  for (std::size_t i = 0; i < points.size(); i += std::max<std::size_t>(1, points.size() / kFew))
    few.push_back(points[i]);
  return few;
}

/** The most by which a corner of the box is elsewhere. */
double apart(const Pose& a, const Pose& b, const Eigen::AlignedBox3d& box) {
  double most = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    most = std::max(most, (a * corner - b * corner).norm());
  }
  return most;
}

}  // namespace

Registration registerFromSeveral(const TreeNearest& surface, const Eigen::AlignedBox3d& box,
                                 const std::vector<Vec3>& points, double offset, const Pose& first_guess) {
  constexpr int kShortRounds = 30;
  constexpr int kFinalists = 6;
  constexpr double kBetter = 0.5, kAsNear = 1.5;
  constexpr double kElsewhere = 0.05;  // Of the points' extent.
  constexpr double kNothing = 1e-9;    // [m]: points without noise.
  const Registration guessed = registerPoints(surface, points, offset, first_guess);
  Eigen::AlignedBox3d measured;
  for (const Vec3& p : points) measured.extend(p);
  const std::vector<Vec3> few = fewOf(points);
  std::vector<Registration> ends;
  for (const Pose& guess : guessesAbout(first_guess, measured, box))
    ends.push_back(registerPoints(surface, few, offset, guess, kShortRounds));
  const auto nearer = [](const Registration& a, const Registration& b) { return a.most < b.most; };
  std::stable_sort(ends.begin(), ends.end(), nearer);

  std::vector<Registration> places;  // Each but once; the first is where the first guess leads, if it settles.
  const auto find = [&](const Registration& r) {
    return std::find_if(places.begin(), places.end(), [&](const Registration& p) {
      return apart(p.X_MO, r.X_MO, measured) < kElsewhere * measured.diagonal().norm();
    });
  };
  const auto isNew = [&](const Registration& r) { return find(r) == places.end(); };
  if (guessed.settled) places.push_back(guessed);
  int finalists = 0;
  for (const Registration& end : ends) {
    if (!isNew(end)) continue;
    if (++finalists > kFinalists) break;
    const Registration place = registerPoints(surface, points, offset, end.X_MO);
    if (place.settled && isNew(place)) places.push_back(place);
  }
  const auto nearest = std::min_element(places.begin(), places.end(), nearer);
  const auto own = find(guessed);  // Where it leads, though from there it may have gone to and fro.
  const Registration& of_guess = own != places.end() ? *own : guessed;
  const bool better = nearest != places.end() && nearest->most + kNothing < kBetter * of_guess.most;
  if (!of_guess.settled && !better) {
    throw Failure("registration", fmt::format("it does not settle; the points are {:.3g} m off", guessed.rms),
                  "a better first guess, or the mesh that was touched");
  }
  Registration found = better ? *nearest : of_guess;
  found.guess_lost = better;
  if (found.guess_lost && of_guess.settled) found.guess_most = of_guess.most;
  const auto as_near = [&](const Registration& r) { return r.most < kAsNear * found.most + kNothing; };
  // Where the surface slides along itself there are ever so many.
  if (found.freedoms == 6) found.as_near = static_cast<int>(std::count_if(places.begin(), places.end(), as_near)) - 1;
  return found;
}

}  // namespace haptic_bench
