// What daemon/resource/json.h prints is what nlohmann::json prints of the same expressions.
#include "daemon/resource/json.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

namespace hapticd::test {
namespace {

std::string printed(const Json& json) { return json.print(); }
std::string printed(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/** Every way in which the daemon builds one. */
template <class J>
std::vector<J> examples() {
  J grown;
  grown["b"] = {{"x", 1}, {"y", {1.5, 2.5, -0.0}}};
  grown["a"]["deep"]["deeper"] = true;
  J list = J::array();
  list.push_back({{"name", "one"}, {"none", nullptr}});
  list.push_back(J::object());
  list.push_back("text");
  J filled;
  filled.push_back(std::string("first"));
  const std::vector<std::string> names{"p", "q"};
  const J pair{{"only", names}};
  return {J(),
          J(nullptr),
          J(true),
          J(names),
          J(std::vector<std::string>{}),
          J::array(),
          J::object(),
          grown,
          list,
          filled,
          pair,
          J(std::numeric_limits<std::uint64_t>::max()),
          J(std::numeric_limits<std::int64_t>::min()),
          J(-1),
          J(1u),
          J(std::string("quote \" back \\ line \n control \x01 del \x7f")),
          J("\xc3\xbc and \xe2\x82\xac"),
          J("no UTF-8: \xff\xc3"),
          J(std::nan("")),
          J(std::numeric_limits<double>::infinity()),
          J{{"b", 1}, {"a", 2}, {"b", 3}},
          J{"two", "texts"},
          J{{"two", "texts"}, {1, 2}},
          J{{"k", J{{"k", J::array()}}}}};
}

TEST(Json, PrintsAsNlohmannDoes) {
  const auto ours = examples<Json>();
  const auto theirs = examples<nlohmann::json>();
  ASSERT_EQ(ours.size(), theirs.size());
  for (std::size_t i = 0; i < ours.size(); ++i) EXPECT_EQ(printed(ours[i]), printed(theirs[i])) << i;
}

TEST(Json, SetsNumbersOutAsNlohmannDoes) {
  for (const double x : {0.0, -0.0, 1.0, -2.5, 0.1, 1e-4, 0.00012, 9.9e-5, 1e-5, 123456.0, 1e14, 999999999999999.0,
                         1e15, 1.5e20, -1e100, 5e-324, 1.7976931348623157e308, 1.0 / 3})
    EXPECT_EQ(printed(Json(x)), printed(nlohmann::json(x)));
}

TEST(Json, SaysEveryNumberSoThatItIsReadBack) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20'000; ++i) {
    const double x = std::bit_cast<double>(random());
    if (std::isfinite(x)) {
      EXPECT_EQ(nlohmann::json::parse(printed(Json(x))).get<double>(), x);
    }
  }
}

TEST(Json, KnowsWhatAnObjectContains) {
  Json json{{"a", nullptr}};
  EXPECT_TRUE(json.contains("a"));
  EXPECT_FALSE(json.contains("b"));
  EXPECT_FALSE(Json("a").contains("a"));
  json["b"];
  EXPECT_TRUE(json.contains("b"));
}

}  // namespace
}  // namespace hapticd::test
