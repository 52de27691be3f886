/** @file
 * Tables with columns of their own: read, judged by the rules of their columns, refused when damaged.
 */
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "tests/support/random.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/result/results.h"
#include "tools/haptic-bench/zwidth/search.h"
#include "tools/haptic-bench/zwidth/sweep.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN(), kInfinite = std::numeric_limits<double>::infinity();

std::string header(const char* benchmark) { return tableForm(benchmark).header() + "\n"; }

/** Walls of one device, whose limits are given. */
std::string walls(const std::vector<double>& off, const char* displayed = "1") {
  std::string text = header("zwidth");
  for (std::size_t i = 0; i < off.size(); ++i)
    text +=
        fmt::format("1000,0,1e-05,0.1,{},0,0,20000,22742.8,12896.1,{},{},{},0,0\n", i, off[i], 2 * off[i], displayed);
  return text;
}

std::string stability(const char* rest) {
  return header("stability") + "brick on floor,dropped,constraint,20," + rest + "\n";
}

/** "worse off, better on" and so on: what compare says of two texts. */
std::string verdicts(const std::string& before, const std::string& after, const Comparison& what = {}) {
  std::string said;
  for (const Change& c : compare(Results::parse(before, "old"), Results::parse(after, "new"), what)) {
    said += (said.empty() ? "" : ", ") + std::string(1, "wbmu"[static_cast<int>(c.kind)]) + " " + c.quantity;
  }
  return said;
}

std::string faultOf(const std::string& text) {
  try {
    (void)Results::parse(text, "t");
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "none";
}

TEST(Tables, EveryColumnSaysHowItIsJudged) {
  const std::set<std::string> ratios{"displayed", "force_relative", "torque_relative", "finite", "fell", "yields",
                                     "lost"};
  for (const TableForm& form : tableForms()) {
    std::set<std::string> names;
    int keys = 0;
    for (const TableColumn& c : form.columns) {
      const std::string name = std::string(form.benchmark) + " " + c.name;
      EXPECT_TRUE(names.insert(c.name).second) << name;
      if (c.role <= TableColumn::Role::kGroup) {
        ++keys;
        continue;
      }
      EXPECT_NE(std::string(c.unit).empty(), ratios.count(c.name) == 0) << name << ": what is its unit?";
      const bool ruled = c.rule.better != Rule::Better::kLess || c.rule.absolute > 0 || c.rule.relative > 0;
      const bool by_rule = c.role == TableColumn::Role::kRepeats || c.role == TableColumn::Role::kMemory;
      EXPECT_EQ(ruled, by_rule) << name << ": by what is it worse?";
    }
    EXPECT_GE(keys, 3) << form.benchmark;
  }
}

TEST(Tables, ALimitIsAsSharpAsItsSearch) {
  for (const TableColumn& c : tableForm("zwidth").columns) {
    if (std::string_view(c.name) != "off" && std::string_view(c.name) != "on") continue;
    EXPECT_GT(c.rule.together, zwidth::kPrecision);
    EXPECT_LT(c.rule.together, zwidth::kPrecision * 1.01);
  }
  EXPECT_EQ(tableForm("zwidth").calm_most, zwidth::kIdealStep);
}

TEST(Tables, RulesHaveASense) {
  const Rule less{Rule::Better::kLess, 1e-3, 0.01}, more{Rule::Better::kMore, 0, 0.01},
      one{Rule::Better::kNearOne, 0.1, 0};
  EXPECT_EQ(judgeByRule(less, 1, 1.009), 0);
  EXPECT_EQ(judgeByRule(less, 1, 1.011), 1);
  EXPECT_EQ(judgeByRule(less, 1.011, 1), -1);
  EXPECT_EQ(judgeByRule(less, 0, 0.9e-3), 0);
  EXPECT_EQ(judgeByRule(less, 0, 1.1e-3), 1);
  EXPECT_EQ(judgeByRule(less, -5, -1), 0) << "energy that is lost";
  EXPECT_EQ(judgeByRule(more, 1000, 989), 1);
  EXPECT_EQ(judgeByRule(more, 1000, 991), 0);
  EXPECT_EQ(judgeByRule(more, 0, 10), -1);
  EXPECT_EQ(judgeByRule(one, 1.05, 0.85), 0) << "0.05 and 0.15 off";
  EXPECT_EQ(judgeByRule(one, 0.95, 1.2), 1);
}

TEST(Tables, WhatIsNoFiniteNumberIsWorseOrBetterToo) {
  const Rule less{Rule::Better::kLess, 1, 0.5}, more{Rule::Better::kMore, 1, 0.5};
  EXPECT_EQ(judgeByRule(less, 5, kInfinite), 1);
  EXPECT_EQ(judgeByRule(less, kInfinite, 5), -1);
  EXPECT_EQ(judgeByRule(more, 5, kInfinite), -1);
  EXPECT_EQ(judgeByRule(more, kInfinite, 5), 1);
  EXPECT_EQ(judgeByRule(less, kInfinite, kInfinite), 0);
  for (const Rule& rule : {less, more}) {
    EXPECT_EQ(judgeByRule(rule, 5, kNone), 1);
    EXPECT_EQ(judgeByRule(rule, kNone, 5), -1);
    EXPECT_EQ(judgeByRule(rule, kNone, kNone), 0);
    EXPECT_EQ(judgeByRule(rule, kInfinite, kNone), 1);
  }
}

TEST(Tables, ARowIsABenchmarkAndItsCellsQuantities) {
  const Results r =
      Results::parse("# cpu: x\n# settings of stability: quick\n" + stability("19,0,1e-9,-1e-12,13.1,-,-,true"), "t");
  ASSERT_EQ(r.all.size(), 8u);
  EXPECT_EQ(r.all[0].benchmark, "stability pair=brick on floor excitation=dropped response=constraint runs=20");
  EXPECT_EQ(r.all[0].series.name, "at_rest");
  EXPECT_EQ(r.all[0].series.unit, "runs");
  EXPECT_EQ(r.all[0].line, 4u);
  EXPECT_TRUE(std::isnan(r.find(r.all[0].benchmark, "creep_m")->series.rounds[0]));
  EXPECT_EQ(r.find(r.all[0].benchmark, "finite")->series.rounds[0], 1);
  EXPECT_EQ(r.settings.at("stability"), "quick");
}

TEST(Tables, EachColumnIsJudgedBySense) {
  const std::string good = stability("20,0,1e-9,-1e-12,13.1,1e-6,1e-5,true");
  EXPECT_EQ(verdicts(good, good), "");
  EXPECT_EQ(verdicts(good, stability("19,0,1e-9,-1e-12,13.1,1e-6,1e-5,true")), "w at_rest");
  EXPECT_EQ(verdicts(stability("19,0,1e-9,-1e-12,13.1,1e-6,1e-5,true"), good), "b at_rest");
  EXPECT_EQ(verdicts(good, stability("20,1,9e-7,2e-9,13.2,3e-6,2e-4,false")),
            "w patience_s, w created_j, w creep_m, w creep_rad, w finite");
  EXPECT_EQ(verdicts(good, stability("20,0,inf,nan,13.1,-,-,true")), "w unrest_m, w created_j, w creep_m, w creep_rad");
}

TEST(Tables, AToolIsHeldMoreHardlyByATenth) {
  const std::string good = stability("20,0,1e-9,0,13.1,-,-,true");
  EXPECT_EQ(verdicts(good, stability("20,0,1e-9,0,14.3,-,-,true")), "");
  EXPECT_EQ(verdicts(good, stability("20,0,1e-9,0,14.5,-,-,true")), "w strongest_n");
  EXPECT_EQ(verdicts(good, stability("19,0,1e-9,0,13.1,-,-,true")), "w at_rest");
  EXPECT_EQ(verdicts(good, stability("20,0.3,1e-9,0,13.1,-,-,true")), "w patience_s");
  EXPECT_EQ(verdicts(good, stability("20,0,1.1e-6,0,13.1,-,-,true")), "w unrest_m");
  EXPECT_EQ(verdicts(good, stability("20,0,0.9e-6,0.9e-9,13.1,-,-,true")), "");
  EXPECT_EQ(verdicts(good, stability("20,0,1e-9,1.1e-9,13.1,-,-,true")), "w created_j");
}

TEST(Tables, WallsThatScatterAreJudgedTogether) {
  std::vector<double> off, scattered, softer;
  const double factor[] = {1.03, 0.96, 1.02, 0.99, 0.75, 1.3, 0.98, 1.01};
  for (int i = 0; i < 8; ++i) {
    off.push_back(10000 + 1000 * i);
    scattered.push_back(off.back() * factor[i]);
    softer.push_back(off.back() * 0.985);
  }
  EXPECT_EQ(verdicts(walls(off), walls(scattered)), "");
  EXPECT_EQ(verdicts(walls(off), walls(softer)), "w off, w on");
  EXPECT_EQ(verdicts(walls(softer), walls(off)), "b off, b on");
  for (double& x : softer) x *= 0.992 / 0.985;
  EXPECT_EQ(verdicts(walls(off), walls(softer)), "") << "within the search";
  const std::vector<double> few(off.begin(), off.begin() + 5), few_softer{8000, 9000, 9800, 10900, 11800};
  EXPECT_EQ(verdicts(walls(few), walls(few_softer)), "") << "too few to tell from scatter";
  softer = off;
  softer[3] /= 1.6;
  EXPECT_EQ(verdicts(walls(off), walls(softer)), "w off, w on") << "one by itself";
  softer[3] = 0;
  EXPECT_EQ(verdicts(walls(off), walls(softer)), "w off, w on") << "none is stable";
  EXPECT_EQ(verdicts(walls(off), walls(off, "1.06")),
            "w displayed, w displayed, w displayed, w displayed, w displayed, "
            "w displayed, w displayed, w displayed");
}

TEST(Tables, WhatIsJudgedTogetherIsToldByItsMeans) {
  // Limits by the mean of their logarithms, buzz by that of its roots.
  const auto text = [](double factor, double more) {
    std::string rows = header("zwidth");
    for (int i = 0; i < 8; ++i) {
      const double root = 0.1 + 0.02 * i + more;
      rows += fmt::format("1000,0,1e-05,0.1,{},0,0,20000,22742.8,12896.1,{},99000,1,{},0\n", i,
                          factor * 1000 * std::pow(2, i), root * root);
    }
    return Results::parse(rows, "t");
  };
  const std::vector<Change> worse = compare(text(1, 0), text(0.97, 0.02), {});
  ASSERT_EQ(worse.size(), 2u);
  EXPECT_EQ(worse[0].quantity + " " + worse[1].quantity, "buzz_off off");
  for (const Change& change : worse) {
    EXPECT_EQ(change.kind, Change::Kind::kWorse);
    EXPECT_EQ(change.benchmark, "zwidth step_m=1e-05 friction_n=0.1, mean of 8 rows");
  }
  EXPECT_NEAR(worse[0].before.median, 0.17 * 0.17, 1e-12);
  EXPECT_NEAR(worse[0].after.median, 0.19 * 0.19, 1e-12);
  EXPECT_NEAR(worse[1].before.median, 1000 * std::pow(2, 3.5), 1e-6);
  EXPECT_NEAR(worse[1].after.median, 970 * std::pow(2, 3.5), 1e-6);
  for (const Change& change : compare(text(0.97, 0.02), text(1, 0), {})) EXPECT_EQ(change.kind, Change::Kind::kBetter);
  EXPECT_TRUE(compare(text(1, 0), text(0.992, 0.009), {}).empty()) << "within bisection, and 10 mN";
}

TEST(Tables, WhatIsJudgedTogetherHasMovedFourStandardErrors) {
  // Logarithms that move by m + 0.02 and m - 0.02 in turn: of eight rows the standard error is 0.02 / sqrt(7).
  const std::vector<double> before(8, 10000.0);
  for (const auto& [m, said] : {std::pair{-0.0290, ""}, {-0.0315, "w off, w on"}, {0.0315, "b off, b on"}}) {
    std::vector<double> after;
    for (int i = 0; i < 8; ++i) after.push_back(1e4 * std::exp(m + (i % 2 == 0 ? 0.02 : -0.02)));
    EXPECT_EQ(verdicts(walls(before), walls(after)), said) << m;
  }
}

TEST(Tables, WallsOfAnIdealEncoderDoNotScatter) {
  const auto ideal = [](double off, double on) {
    return header("zwidth") + fmt::format("1000,0,1e-09,0,5,0,0,0,22742.8,12896.1,{},{},1,0.002,0\n", off, on);
  };
  EXPECT_EQ(verdicts(ideal(10000, 50000), ideal(9910, 48700)), "");
  EXPECT_EQ(verdicts(ideal(10000, 50000), ideal(9890, 48700)), "w off");
  EXPECT_EQ(verdicts(ideal(10000, 50000), ideal(10110, 48000)), "b off, w on");
}

TEST(Tables, TimesOfOneRoundAreNotJudgedAndMemoryOnlyOnOneMachine) {
  const auto collide = [](const char* cells) {
    return header("collide") + "peg,\"one-sided, finer field\",touch," + cells + "\n";
  };
  const std::string before = collide("15,1,1,1,1,1,1,100,90,500,1.9,1.5,0.5,2"),
                    after = collide("9,2,2,2,2,2,2,90,40,900,2.9,1.6,-,2.01");
  EXPECT_EQ(verdicts(before, after),
            "u mean, u p50, u p99, u p99.9, u steady, u max, w records, u rate, u build, w MB, w force, w angle");
  EXPECT_EQ(verdicts(before, after, {false, false}), "w records, w force, w angle");
}

TEST(Tables, RowsThatAreGoneAreMissing) {
  EXPECT_EQ(verdicts(walls({1, 2}), walls({1})).substr(0, 20), "m colgate, m colgate");
}

TEST(Tables, OtherSettingsAreTold) {
  const auto with = [](const char* push) {
    return Results::parse(fmt::format("# settings of zwidth: {}\n", push) + walls({1}), "t");
  };
  EXPECT_EQ(otherSettings(with("4 N"), with("8 N")), "zwidth");
  EXPECT_EQ(otherSettings(with("4 N"), with("4 N")), "");
  EXPECT_EQ(otherSettings(with("4 N"), Results::parse(walls({1}), "t")), "");
}

TEST(Tables, MistakesAreNamedWithTheirLine) {
  const std::string good = walls({1000, 2000}), first = good.substr(good.find('\n') + 1);
  const std::string row = first.substr(0, first.find('\n') + 1);
  const std::pair<std::string, const char*> mistakes[] = {
      {good.substr(0, good.size() - 4), "t, line 3: it is cut off"},
      {good.substr(0, good.size() - 4) + "\n", "t, line 3: it has 14 fields, and 15 the header in line 1"},
      {header("zwidth"), "t, line 1: no row follows this header"},
      {"# cpu: x\n" + header("zwidth") + header("sixdof"), "t, line 2: no row follows this header"},
      {std::string(kResultsHeader) + "\n", "t, line 1: nothing follows this header"},
      {good + row, "t, line 4: this row stands above already"},
      {good + "1000,0,1e-05,0.1,x" + row.substr(18), "t, line 4: \"x\" in column damping is no number"},
      {row, "t, line 1: it is no result"},
      {"delay_ticks,rate_hz" + good.substr(19), "t, line 1: zwidth's columns are in another order"},
      {"rate_hz,rate_hz" + good.substr(19), "t, line 1: column rate_hz stands twice"},
      {good.substr(8), "t, line 1: zwidth's column rate_hz is missing"},
      {"spring," + good, "t, line 1: zwidth of this version has no column \"spring\""},
      {"triangles,what,mean,median,p99,p99.9,max,chase\n1152,tick 0 mm,1,1,1,1,1,1\n",
       "t, line 1: an older version of haptic-bench cost has written it (measure again with this version"},
      {"# settings of zwidth: 4 N\n" + good + "# settings of zwidth: 8 N\n",
       "t, line 5: zwidth stands above with other settings"},
      {header("stability") + "a,\"b,c,20,20,0,0,0,0,0,0,true\n", "t, line 2: its quotes do not close"},
      {"", "t: there are no results in it"},
  };
  for (const auto& [text, fault] : mistakes) {
    EXPECT_THAT(faultOf(text), HasSubstr(fault)) << text;
    EXPECT_THAT(faultOf(text), ::testing::EndsWith(")")) << "a remedy";
  }
  EXPECT_EQ(faultOf(good), "none");
}

/** Of any damage a fault is named, or what is left compares with itself without a change. */
TEST(Tables, DamagedFilesAreRefusedOrRead) {
  const std::string whole = "# settings of zwidth: 4 N\n" + walls({1000, 2000, 3000, 4000, 5000, 6000}) +
                            stability("20,0,1e-9,-1e-12,13.1,-,-,true") + std::string(kResultsHeader) +
                            "\nb,q,ns,1,5\nb,q,ns,2,6\n";
  hapticd::Random random(1);
  int refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text = whole;
    for (int n = 1 + random.below(3); n > 0 && text.size() > 1; --n) {
      const auto at = random.below(text.size() - 1);
      const auto length = random.below<std::size_t>(40);
      switch (random.below(5)) {
        case 0:
          text[at] = ",\n\"#-.0enx"[random.below(10)];
          break;
        case 1:
          text.erase(at, length);
          break;
        case 2:
          text.insert(at, text.substr(random.below(text.size()), length));
          break;
        case 3:
          text.resize(at + 1);
          break;
        default:
          std::swap(text[at], text[at + 1]);
      }
    }
    try {
      const Results results = Results::parse(text, "t");
      EXPECT_FALSE(results.all.empty());
      for (const Change& change : compare(results, results, {true, true}))
        EXPECT_EQ(change.kind, Change::Kind::kUnknown) << text;
    } catch (const Failure& failure) {
      ++refused;
      EXPECT_EQ(std::string_view(failure.what()).substr(0, 1), "t");
    }
  }
  EXPECT_GT(refused, 10'000);
}

}  // namespace
}  // namespace haptic_bench
