#include "drivers/woodyhid/woody_model.h"

namespace hapticd {
namespace {

/** Both alike but for their motors. */
WoodyModel woodenHaptics(std::string_view name, std::string_view title, const Vec3& torque_constant) {
  return {.name = name,
          .title = title,
          .capstan = {0.010, 0.010, 0.010},
          .body = {0.160, 0.120, 0.120},
          .La = 0.080,
          .Lb = 0.205,
          .Lc = 0.245,
          .origin = {0.220, 0, 0.080},
          .torque_constant = torque_constant,
          .counts_per_turn = 2000,
          .max_force = 5,
          .max_stiffness = 1000,
          .max_damping = 8,
          .calibration = {0, 0, 6000, 0, 0, 0},
          .masses = {{{0.170, 0.051, 0}, {0.110, 0.091, 0}, {}, {}}}};
}

const WoodyModel kModels[] = {
    woodenHaptics("woodenhaptics_v2015", "WoodenHaptics (2015)", {0.0259, 0.0259, 0.0259}),
    woodenHaptics("woodenhaptics_v2019", "WoodenHaptics (2019)", {0.321, 0.0603, 0.0603}),
    {.name = "aluhaptics_v2",
     .title = "AluHaptics 2",
     .capstan = {0.0138, 0.0098, 0.0098},
     .body = {0.116, 0.076, 0.076},
     .La = 0.111,
     .Lb = 0.140,
     .Lc = 0.111,
     .origin = {0.140, 0, 0},
     .torque_constant = {0.0259, 0.0259, 0.0259},
     .counts_per_turn = 2000,
     .max_force = 5,
     .max_stiffness = 1000,
     .max_damping = 8},
    {.name = "vintage",
     .title = "Vintage",
     .capstan = {0.013, 0.010, 0.010},
     .body = {0.117, 0.077, 0.077},
     .La = 0.056,
     .Lb = 0.138,
     .Lc = 0.112,
     .origin = {0.140, 0, 0},
     .torque_constant = {0.0163, 0.0163, 0.0163},
     .counts_per_turn = 4000,
     .max_force = 5,
     .max_stiffness = 800,
     .max_damping = 8},
    {.name = "polhem_v1",
     .title = "Polhem 1",
     .capstan = {0.010, 0.010, 0.010},
     .body = {0.180, 0.100, 0.100},
     .La = 0.058,
     .Lb = 0.174,
     .Lc = 0.133,
     .origin = {0.140, 0, 0.100},
     .torque_constant = {0.0538, 0.0538, 0.0538},
     .counts_per_turn = 2000,
     .gimbal_counts_per_turn = 1024,
     .max_force = 5,
     .max_stiffness = 800,
     .max_damping = 8,
     .calibration = {0, 0, -5000, 0, 0, 0},
     .aligned = {true, true, true}},
    {.name = "polhem_v3",
     .title = "Polhem 3",
     .linkage = WoodyLinkage::kFiveBar,
     .capstan = {0.0288, 0.0130, 0.010},
     .body = {0.175, 0.100, 0.100},
     .bars = {0.034, 0.165, 0.025, 0.190, 0.034, 0.1308},
     .origin = {0.2045, 0, 0.0325},
     .torque_constant = {0.0603, 0.0538, 0.0538},
     .counts_per_turn = 4096,
     .gimbal_counts_per_turn = 1024,
     .max_force = 5,
     .max_stiffness = 2000,
     .max_damping = 1,
     .calibration = {8327, -10926, 27140, 0, 30, 0},
     .aligned = {false, true, false},
     .masses = {{{0.15764, 0.030123, 0.000484},
                 {0.07733, -0.004086, 0.001911},
                 {0.09767, 0.087765, 0.001978},
                 {0.11265, 0.061701, 0.000576}}}},
};

}  // namespace

std::span<const WoodyModel> woodyModels() { return kModels; }

const WoodyModel* findWoodyModel(std::string_view name) {
  for (const WoodyModel& model : kModels) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

}  // namespace hapticd
