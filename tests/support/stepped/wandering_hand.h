/** @file
 * A hand for random scenes.
 */
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "rt/base/math.h"
#include "tests/support/random.h"

namespace hapticd::test {

/** A hand that wanders, throws itself about, and now and then rests. */
class WanderingHand {
 public:
  WanderingHand(Random& random, double size, std::vector<Vec3> about = {Vec3::Zero()})
      : random_(random), size_(size), about_(std::move(about)) {}
  const Vec3& next() {
    if (random_.below(20) == 0) {
      aim_ = about_[static_cast<std::size_t>(random_.below(static_cast<int>(about_.size())))] + random_.vector(size_);
    }
    if (random_.below(30) == 0) speed_ = std::pow(10.0, random_.in(-3, -0.3));
    if (random_.below(200) == 0) p_ = random_.vector(size_);
    p_ += speed_ * (aim_ - p_);
    return p_;
  }

 private:
  Random& random_;
  double size_, speed_ = 0.01;
  std::vector<Vec3> about_;
  Vec3 p_ = Vec3::Zero(), aim_ = Vec3::Zero();
};

}  // namespace hapticd::test
