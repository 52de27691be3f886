// Whatever the keys and whatever the host sends: samples stay finite, forces within the device's limit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "drivers/sim/sim_device.h"
#include "tests/support/seeds.h"

namespace hapticd {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  /** An end of the range one time in three: corners break things. */
  double within(double lowest, double highest) {
    const double u = unit();
    return u < 1.0 / 6 ? lowest : u < 1.0 / 3 ? highest : lowest + (highest - lowest) * std::pow(unit(), 3);
  }
  std::string_view word(std::string_view choices) {
    std::vector<std::string_view> words;
    for (std::size_t begin = 0; begin <= choices.size();) {
      const std::size_t end = std::min(choices.find('|', begin), choices.size());
      if (choices.substr(begin, end - begin) != "csv") words.push_back(choices.substr(begin, end - begin));
      begin = end + 1;
    }
    return words[static_cast<std::size_t>(unit() * 0.999999 * static_cast<double>(words.size()))];
  }
  double force() {
    const double u = unit();
    if (u < 0.02) return std::numeric_limits<double>::quiet_NaN();
    if (u < 0.04) return std::numeric_limits<double>::infinity();
    if (u < 0.06) return 1e308;
    return 50 * (unit() - 0.5);
  }

 private:
  std::mt19937 random_;
};

SimParameters randomParameters(Draw& draw) {
  SimParameters p;
  for (const Parameter<SimParameters>& parameter : simParameterTable()) {
    const ParameterSpec& spec = parameter.spec;
    if (spec.key == "file" || spec.key == "serial" || draw.unit() < 0.5) continue;
    const ParameterSlot slot = parameter.slot(p);
    const auto number = [&] { return draw.within(spec.lowest, spec.highest); };
    if (auto* value = std::get_if<double*>(&slot)) **value = number();
    if (auto* value = std::get_if<std::uint64_t*>(&slot)) **value = static_cast<std::uint64_t>(number());
    if (auto* value = std::get_if<bool*>(&slot)) **value = draw.unit() < 0.5;
    if (auto* value = std::get_if<Vec3*>(&slot)) **value = Vec3(number(), number(), number());
    if (auto* value = std::get_if<std::string*>(&slot)) **value = draw.word(spec.choices);
  }
  p.dof = p.dof > 4 ? 6 : 3;
  p.gripper_angle = std::min(p.gripper_angle, p.gripper_max_angle);
  for (int i = 0; i < 3; ++i) {
    if (p.upper[i] < p.lower[i]) std::swap(p.upper[i], p.lower[i]);
    if (p.upper[i] - p.lower[i] < 1e-3) p.upper[i] = p.lower[i] + 2e-3;
    if (p.box_upper[i] < p.box_lower[i]) std::swap(p.box_upper[i], p.box_lower[i]);
  }
  if (p.upper.maxCoeff() > 2) p.lower = -(p.upper = Vec3(0.1, 0.1, 0.1));
  if (p.direction.norm() < 1e-3) p.direction = Vec3::UnitX();
  if (p.normal.norm() < 1e-3) p.normal = Vec3::UnitX();
  return p;
}

TEST(SimDevice, AnyKeysAndAnyCommandsKeepSamplesFiniteAndForcesLimited) {
  Draw draw(seedOf(20));
  for (int trial = 0; trial < 300; ++trial) {
    const DeviceUri uri{"sim", "default", difference(simParameterTable(), randomParameters(draw), SimParameters{})};
    SCOPED_TRACE(formatDeviceUri(uri));
    Result<SimSetup> setup = resolveSim(uri);
    ASSERT_TRUE(setup.ok()) << toString(setup.error());
    const DeviceInfo info = setup->info;
    const SimParameters p = setup->parameters;
    SimDevice device(std::move(*setup));
    ASSERT_TRUE(device.open().ok());
    DeviceSample sample;
    std::int64_t now_ns = 0;
    for (int i = 0; i < 100; ++i) {
      now_ns += static_cast<std::int64_t>(draw.within(0, 3e6));
      device.read(now_ns, sample);
      ASSERT_TRUE(isFinite(sample.p) && isFinite(sample.q) && std::isfinite(sample.gripper_rad));
      ASSERT_NEAR(sample.q.norm(), 1, 1e-9);
      ASSERT_LE(device.acting().force.norm(), p.max_force * (1 + 1e-12));
      ASSERT_LE(device.acting().torque.norm(), info.actuated_rotation ? p.max_torque * (1 + 1e-12) : 0);
      ASSERT_LE(std::abs(device.acting().gripper_force), p.gripper ? p.max_gripper_force : 0);
      DeviceCommand command;
      command.enabled = draw.unit() < 0.9;
      command.force = Vec3(draw.force(), draw.force(), draw.force());
      command.torque = Vec3(draw.force(), draw.force(), draw.force());
      command.gripper_force = draw.force();
      device.write(now_ns, command);
      DeviceIntent intent;
      intent.p = Vec3(draw.force(), draw.force(), draw.force()) * 0.01;
      intent.q.coeffs() << draw.force(), draw.force(), draw.force(), draw.force();
      device.setIntent(intent);
    }
  }
}

}  // namespace
}  // namespace hapticd
