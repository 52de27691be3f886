// What each number in the configuration may be: the bounds as they are promised, and that the reader keeps them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "daemon/config/config_schema.h"

namespace hapticd {
namespace {

using Bounds = std::pair<double, double>;

/** Collects "section key" and its bounds, of every key that is a number. */
class Collector {
 public:
  std::map<std::string, Bounds> all;

  void number(std::string_view key, double, double least, double most) { add(key, least, most); }
  void integer(std::string_view key, std::uint32_t, std::int64_t least, std::int64_t most) {
    add(key, static_cast<double>(least), static_cast<double>(most));
    whole.insert(place(key));
  }
  void integers(std::string_view key, const std::vector<std::uint32_t>&, std::int64_t least, std::int64_t most) {
    add(key, static_cast<double>(least), static_cast<double>(most));
    lists.insert(place(key));
  }
  void triple(std::string_view key, const std::vector<double>&, double least, double most) {
    add(key, least, most);
    triples.insert(place(key));
  }
  template <class Value>
  void flag(std::string_view, const Value&) {}
  template <class Value>
  void text(std::string_view, const Value&) {}
  template <class Value>
  void mode(std::string_view, const Value&) {}
  template <class Value>
  void level(std::string_view, const Value&) {}
  template <class Value>
  void texts(std::string_view, const Value&) {}
  template <class Visit>
  void table(std::string_view key, Visit&& visit) {
    section_ = fmt::format("[{}]", key);
    visit(*this);
  }
  template <class Element, class Visit>
  void tables(std::string_view key, const std::vector<Element>& elements, Visit&& visit) {
    section_ = fmt::format("[[{}]]", key);
    for (const Element& element : elements) visit(*this, element);
  }

  std::set<std::string> whole, lists, triples;

 private:
  [[nodiscard]] std::string place(std::string_view key) const { return fmt::format("{}\n{}", section_, key); }
  void add(std::string_view key, double least, double most) { all[place(key)] = {least, most}; }

  std::string section_;
};

Collector collected() {
  Config one_of_each;
  one_of_each.groups.resize(1);
  one_of_each.devices.resize(1);
  one_of_each.lines.resize(1);
  Collector out;
  visitConfig(out, one_of_each);
  return out;
}

TEST(ConfigBounds, AreThoseThatWereChosen) {
  std::map<std::string, Bounds> expected{
      {"[servo]\nrate_hz", {1000, 4000}},       {"[servo]\nservo_priority", {2, 98}},
      {"[servo]\ningest_priority", {1, 97}},    {"[servo]\ngpio_priority", {1, 98}},
      {"[servo]\nmissed_limit", {1, 1e5}},      {"[guard]\narm_ramp_ms", {100, 6e4}},
      {"[guard]\nsmall_force_n", {0.001, 10}},  {"[guard]\nsmall_force_ticks", {1, 1e4}},
      {"[guard]\ndevice_stale_ms", {1, 1000}},  {"[guard]\nmotor_heating_s", {0, 3600}},
      {"[sessions]\nloss_fade_ms", {1, 50}},    {"[sessions]\nstale_after_ms", {50, 1e4}},
      {"[sessions]\nbudget_per_tick", {1, 64}}, {"[sessions]\nmax_ahead_s", {0, 3600}},
      {"[sessions]\nevent_buffer", {16, 1e6}},  {"[quotas]\nsessions", {1, 16}},
      {"[quotas]\nmemory_mb", {2, 1e6}},        {"[quotas]\nobjects", {0, 255}},
      {"[quotas]\ntriangles", {0, 16e6}},       {"[builder]\nmemory_mb", {64, 1e6}},
      {"[builder]\ntimeout_s", {1, 3600}},      {"[builder]\ncache_mb", {0, 1e6}},
      {"[[group]]\nrate_hz", {1000, 4000}},     {"[[group]]\ncpus", {0, 1023}},
      {"[[device]]\nradius_m", {0, 0.1}},       {"[[line]]\ndebounce_ms", {0, 100}},
      {"[[device]]\nmount_m", {-100, 100}},     {"[[device]]\nmount_deg", {-360, 360}},
      {"[[device]]\nscale", {0.01, 100}},       {"[[device]]\nclutch_button", {0, 32}}};
  for (const std::string section : {"[limits]\n", "[[device]]\n"}) {
    expected[section + "force_n"] = {0, 200};
    expected[section + "torque_nm"] = {0, 50};
    expected[section + "gripper_force_n"] = {0, 200};
    expected[section + "force_slew_n_per_s"] = {1, 1e6};
    expected[section + "torque_slew_nm_per_s"] = {0.1, 1e6};
    expected[section + "velocity_m_per_s"] = {0.01, 50};
    expected[section + "power_w"] = {0, 1000};
    expected[section + "active_power_w"] = {0, 1000};
  }
  EXPECT_EQ(collected().all, expected);
}

TEST(ConfigBounds, AreThemselvesTakenAndNothingBeyond) {
  const Collector keys = collected();
  for (const auto& [place, bounds] : keys.all) {
    const bool list = keys.lists.contains(place);
    const bool whole = list || keys.whole.contains(place);
    const auto inBounds = [&, &place = place](double value) {
      const bool triple = keys.triples.contains(place);
      const char *before = list ? "[" : triple ? "[0, " : "", *after = list ? "]" : triple ? ", 0]" : "";
      const auto read = parseConfig(fmt::format("{} = {}{}{}\n", place, before, value, after), "f");
      return read.ok() || read.error().what.find("is out of range") == std::string::npos;
    };
    const auto beyond = [&](double bound, double to) {
      return whole ? bound + std::copysign(1, to) : std::nextafter(bound, to);
    };
    constexpr double kFar = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(inBounds(bounds.first)) << place;
    EXPECT_TRUE(inBounds(bounds.second)) << place;
    EXPECT_FALSE(inBounds(beyond(bounds.first, -kFar))) << place;
    EXPECT_FALSE(inBounds(beyond(bounds.second, kFar))) << place;
  }
}

TEST(ConfigBounds, OfPermissions) {
  for (const std::string key : {"mode", "admin_mode"}) {
    const auto taken = [&](const char* value) { return parseConfig("[sockets]\n" + key + " = " + value, "f").ok(); };
    EXPECT_TRUE(taken("0o000") && taken("0o777") && taken("0")) << key;
    EXPECT_FALSE(taken("-1") || taken("0o1000")) << key;
    EXPECT_FALSE(taken("440") || taken("0x1b0") || taken("1")) << key << " in another base than file permissions have";
  }
}

}  // namespace
}  // namespace hapticd
