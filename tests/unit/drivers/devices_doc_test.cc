// docs/devices.md lists every key and every preset as the tables have them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "drivers/falcon/falcon_parameters.h"
#include "drivers/hidpid/hidpid_parameters.h"
#include "drivers/pantograph/pantograph_parameters.h"
#include "drivers/replay/replay_device.h"
#include "drivers/sim/sim_parameters.h"
#include "drivers/spacemouse/spacemouse_parameters.h"
#include "drivers/vendor/vendor_parameters.h"
#include "drivers/woodyhid/woodyhid_parameters.h"

namespace hapticd {
namespace {

std::string page() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/docs/devices.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

template <class S>
std::string keyTable(const std::vector<Parameter<S>>& table) {
  std::string text = "| key | default | takes | meaning |\n|---|---|---|---|\n";
  S defaults;
  for (const Parameter<S>& parameter : table) {
    const ParameterSlot slot = parameter.slot(defaults);
    const std::string value = formatParameter(slot);
    text += fmt::format("| `{}` | {} | {} | {} |\n", parameter.spec.key, value.empty() ? "" : "`" + value + "`",
                        describeRange(parameter.spec, slot), parameter.spec.doc);
  }
  return text;
}

/** Figures that nobody published are the default's, in parentheses. */
std::string presetTable() {
  const SimParameters ours;
  const auto figure = [](double value, double unit, bool published) {
    const std::string text = fmt::format("{:.4g}", value * unit);
    return published ? text : "(" + text + ")";
  };
  std::string text =
      "| preset | device | box x, y, z mm | step um | force N (continuous) | stiffness N/m | damping N s/m | mass g | "
      "dry "
      "friction N | rate Hz | also |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const SimPreset& preset : simPresets()) {
    const SimParameters& p = preset.parameters;
    const bool mine = preset.name == "default";
    const Vec3 box = (p.upper - p.lower) * 1000;
    const DeviceInfo info = resolveSim({"sim", std::string(preset.name), {}})->info;
    std::string also = p.dof == 6 ? "torque" : p.sense_rotation ? "senses rotation" : "";
    if (p.gripper) also += also.empty() ? "gripper" : ", gripper";
    text += fmt::format(
        "| `{}` | {} {} | {:.4g}, {:.4g}, {:.4g} | {} | {:.4g}{} | {:.4g}{} | {:.4g}{} | {} | {} | {:.4g} | {} |\n",
        preset.name, preset.manufacturer, preset.model, box.x(), box.y(), box.z(), figure(p.resolution, 1e6, true),
        p.max_force, p.continuous_force > 0 ? fmt::format(" ({:.4g})", p.continuous_force) : "", info.max_stiffness,
        p.max_stiffness > 0 ? "" : " computed", info.max_damping, p.max_damping > 0 ? "" : " computed",
        figure(p.mass, 1e3, mine || p.mass != ours.mass), figure(p.coulomb, 1, mine || p.coulomb != ours.coulomb),
        p.rate, also);
  }
  return text;
}

void expectInPage(const std::string& table) {
  if (page().find(table) == std::string::npos) ADD_FAILURE() << "docs/devices.md must contain:\n" << table;
}

TEST(DevicesPage, ListsEveryKeyOfTheSimulator) { expectInPage(keyTable(simParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfReplay) { expectInPage(keyTable(replayParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfTheFalcon) { expectInPage(keyTable(falconParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfWoodenHaptics) { expectInPage(keyTable(woodyParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfTheSpaceMouse) { expectInPage(keyTable(spaceMouseParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfForceFeedback) { expectInPage(keyTable(hidPidParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfThePantograph) { expectInPage(keyTable(pantographParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfForceDimension) { expectInPage(keyTable(dhdParameterTable())); }
TEST(DevicesPage, ListsEveryKeyOfOpenHaptics) { expectInPage(keyTable(hdParameterTable())); }
TEST(DevicesPage, ListsEveryPreset) { expectInPage(presetTable()); }

}  // namespace
}  // namespace hapticd
