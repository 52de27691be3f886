/** @file
 * The order that sets a device up elsewhere.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/command.h"

namespace hapticd::test {

[[nodiscard]] inline SetMount mountAt(const Pose& X_WD, std::uint32_t device = 0, double scale = 1) {
  SetMount order{device, 0, {}, {}, scale};
  store(X_WD.p, order.p);
  store(X_WD.q, order.q);
  return order;
}

}  // namespace hapticd::test
