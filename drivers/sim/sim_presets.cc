/** @file
 * Device classes by their published limits. Only `default` is ours; a figure that nobody published is left at the value
 * of `default` and marked so in docs/devices.md.
 */
#include "drivers/sim/sim_parameters.h"

namespace hapticd {

const std::vector<SimPreset>& simPresets() {
  static const std::vector<SimPreset> kPresets = [] {
    std::vector<SimPreset> list;
    list.push_back({"default", "default", "hapticd", "a desktop device of the omega.3 class", SimParameters{}});
    return list;
  }();
  return kPresets;
}

}  // namespace hapticd
