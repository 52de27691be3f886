/** @file
 * Results: written, read, compared.
 */
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/result/results.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Results one(const std::string& unit, std::vector<double> rounds, const std::string& benchmark = "b") {
  Results r;
  r.all.push_back({benchmark, {"q", unit, std::move(rounds)}});
  return r;
}

/** What compare says of one quantity: w(orse), b(etter), m(issing), u(nknown), n(o interval), o(ther unit) or -. */
char verdict(const std::string& unit, std::vector<double> before, std::vector<double> after, Comparison what = {},
             const std::string& benchmark = "b") {
  const std::vector<Change> changes =
      compare(one(unit, std::move(before), benchmark), one(unit, std::move(after), benchmark), what);
  if (changes.empty()) return '-';
  return "wbmuno"[static_cast<int>(changes[0].kind)];
}

TEST(CompareResults, TimesChangeBeyondTheNoiseOfTheirRounds) {
  const std::vector<double> steady{100, 101, 102, 103, 104, 105}, noisy{90, 95, 100, 106, 120, 130};
  EXPECT_EQ(verdict("ns", steady, noisy), '-') << "the intervals meet";
  EXPECT_EQ(verdict("ns", steady, {110, 111, 112, 113, 114, 115}), 'w');
  EXPECT_EQ(verdict("ns", {110, 111, 112, 113, 114, 115}, steady), 'b');
  EXPECT_EQ(verdict("ns", {100, 100, 100, 100, 100, 110}, {110, 111, 112, 113, 114, 115}), '-') << "one is shared";
  EXPECT_EQ(verdict("ns", {110, 111, 112, 113, 114, 115}, {100, 100, 100, 100, 100, 110}), '-') << "one is shared";
  EXPECT_EQ(verdict("ns", {100, 100, 100, 100, 100, 100}, {101, 101, 101, 101, 101, 101}), '-') << "one per cent";
  EXPECT_EQ(verdict("N/m", steady, {80, 81, 82, 83, 84, 85}), 'w') << "less stiffness";
  EXPECT_EQ(verdict("ns", steady, {200, 200, 200, 200, 200, 200}, {false, true}), '-') << "not asked for";
}

TEST(CompareResults, ErrorsAreComparedToABillionth) {
  EXPECT_EQ(verdict("N^2", {4}, {4 + 3e-9}), '-') << "0.75e-9 N";
  EXPECT_EQ(verdict("N^2", {4}, {4 + 6e-9}), 'w') << "1.5e-9 N";
  EXPECT_EQ(verdict("N^2", {4 + 6e-9}, {4}), 'b');
  EXPECT_EQ(verdict("J", {-1e-3}, {-2e-3}), 'w') << "further from zero";
  EXPECT_EQ(verdict("samples", {5}, {6}), 'w');
  EXPECT_EQ(verdict(kForceErrorUnit, {1}, {1.001}, {false, false}), 'w') << "of models, on any machine";
  EXPECT_EQ(verdict("N", {0.9, 1, 1.1}, {0.95, 1.01, 1.2}), '-') << "how hard a live hand pressed is no error";
}

TEST(CompareResults, WhatIsCountedIsJudgedOnAnyMachine) {
  EXPECT_EQ(verdict(kCountedUnit, {41.2}, {41.201}, {false, false}), 'w');
  EXPECT_EQ(verdict(kCountedUnit, {41.2}, {41.1}, {false, false}), 'b');
  EXPECT_EQ(verdict(kCountedUnit, {41.2}, {41.2}), '-');
}

TEST(CompareResults, TimesOfFewRoundsAreNotJudged) {
  EXPECT_EQ(verdict("ns", {100}, {110}), 'u');
  EXPECT_EQ(verdict("us", {1, 2, 3, 4, 5, 6}, {10, 11, 12, 13, 14}), 'u');
  EXPECT_EQ(verdict("s", {1, 2, 3, 4, 5}, {10, 11, 12, 13, 14, 15}), 'u');
  EXPECT_EQ(verdict("s", {1, 2, 3, 4, 5, 6}, {10, 11, 12, 13, 14, 15}), 'w');
  EXPECT_EQ(verdict("N^2", {1}, {2}), 'w') << "errors repeat";
  EXPECT_EQ(verdict("%", {1}, {2}), 'w') << "ratios of what repeats do too";
  EXPECT_EQ(verdict("byte", {100}, {200}), 'w');
}

TEST(CompareResults, WhatRunsAgainstTheClockIsJudgedLikeATime) {
  for (const char* unit : {"ns per message", "us a tick"}) EXPECT_EQ(verdict(unit, {100}, {110}), 'u') << unit;
  for (const char* unit : {"%", "N", ""})
    EXPECT_EQ(verdict(unit, {1}, {2}, {}, "load"), 'u') << "a live hand: " << unit;
  EXPECT_EQ(verdict("", {1}, {2}, {}, "servo"), 'u') << "a ratio of times";
  EXPECT_EQ(verdict("ticks", {2}, {3}, {}, "ring"), 'w') << "counted";
  EXPECT_EQ(verdict("ticks", {2}, {3}, {false, false}, "ring"), 'w') << "on any machine";
  EXPECT_EQ(verdict("%", {1, 1, 1, 1, 1, 1}, {2, 2, 2, 2, 2, 2}, {}, "load"), 'w');
}

// Of six rounds and more they were still called times of fewer rounds, for there is one value of them.
TEST(CompareResults, VirtualTimesAreJudgedByOneRoundOnAnyMachine) {
  for (const Comparison what : {Comparison{}, Comparison{false, false}}) {
    EXPECT_EQ(verdict(kVirtualTimeUnit, {2000}, {9000}, what, "device"), 'w');
    EXPECT_EQ(verdict(kVirtualTimeUnit, {9000}, {2000}, what, "device"), 'b');
    EXPECT_EQ(verdict(kVirtualTimeUnit, {2000}, {2000 + 1e-10}, what, "device"), '-');
  }
}

TEST(CompareResults, WhatIsPooledIsJudgedByItsInterval) {
  const auto servo = [](double ratio, double low, double high, double tail) {
    Results r;
    r.all.push_back({"servo", {"daemon wake max", "us", {1, 2, 3, 4, 5, 6}}});
    r.all.push_back({"servo", {"daemon wake p99, all slices", "us", {tail}}});
    r.all.push_back({"servo", {"wake p99, daemon / bare, all slices", "", {ratio}}});
    r.all.push_back({"servo", {"wake p99, daemon / bare, 95 % low", "", {low}}});
    r.all.push_back({"servo", {"wake p99, daemon / bare, 95 % high", "", {high}}});
    return r;
  };
  const auto kinds = [](const Results& a, const Results& b) {
    std::string text;
    for (const Change& c : compare(a, b, {})) text += "wbmuno"[static_cast<int>(c.kind)];
    return text;
  };
  const Results before = servo(1.5, 1.4, 1.6, 9);
  EXPECT_EQ(kinds(before, servo(2.5, 2.3, 2.7, 90)), "nw");
  EXPECT_EQ(kinds(servo(2.5, 2.3, 2.7, 90), before), "nb");
  EXPECT_EQ(kinds(before, servo(1.7, 1.5, 1.9, 90)), "n") << "the intervals meet";
  EXPECT_EQ(roundsToJudge(before), 6u);
  EXPECT_FALSE(isCompared(before.all[4], {}));
}

// "missing" for every row of AVX-512 ended each comparison of two machines with 1.
TEST(CompareResults, RowsOfAVectorUnitThatTheOtherMachineLacksAreNotMissed) {
  const auto machine = [](std::initializer_list<const char*> rows) {
    std::string text = tableForm("collide").header() + "\n";
    for (const char* row : rows) text += fmt::format("bumpy,{},1,1,1,1,1,1,1,500,1,1,10.0,0.50,0.10,0.50\n", row);
    return Results::parse(text, "t");
  };
  const Results newer =
      machine({"278k AVX-512,contacts", "278k AVX-512,fifth", "278k AVX2,contacts", "278k portable,contacts"});
  const Results older = machine({"278k AVX2,contacts", "278k AVX2,fifth", "278k portable,contacts"});
  const auto missing = [](const Results& a, const Results& b, const Comparison& what) {
    int count = 0;
    for (const Change& c : compare(a, b, what)) count += c.kind == Change::Kind::kMissing ? 1 : 0;
    return count;
  };
  const Results plain = machine({"278k portable,contacts", "278k portable,fifth"});
  for (const auto& [a, b] : {std::pair{&newer, &older}, {&older, &newer}, {&plain, &older}, {&newer, &plain}}) {
    EXPECT_EQ(missing(*a, *b, {false, false}), 0);
    EXPECT_GT(missing(*a, *b, {}), 0) << "of one machine";
  }
  EXPECT_GT(missing(newer, machine({"278k AVX-512,contacts", "278k portable,contacts"}), {false, false}), 0);
  EXPECT_GT(missing(older, machine({"278k AVX2,contacts", "278k AVX2,fifth"}), {false, false}), 0);
}

TEST(CompareResults, OfMeansAndTailsNoRoundMayBeShared) {
  std::vector<double> before, after;  // Twenty per cent slower, but for two rounds that something disturbed.
  for (int i = 0; i < 15; ++i) before.push_back(i < 2 ? 130 : 100 + i), after.push_back(120 + i);
  const auto changes = [](const std::string& name, const std::vector<double>& a, const std::vector<double>& b) {
    Results old, now;
    old.all.push_back({"run", {name, "ns", a}});
    now.all.push_back({"run", {name, "ns", b}});
    return compare(old, now, {}).size();
  };
  EXPECT_EQ(changes("ours median", before, after), 1u);
  for (const char* name : {"ours mean", "ours p99", "ours init"}) EXPECT_EQ(changes(name, before, after), 0u) << name;
  before[0] = before[1] = 100;
  EXPECT_EQ(changes("ours mean", before, after), 1u);
}

TEST(CompareResults, ManyQuantitiesNeedMoreRounds) {
  // Of 400 that differ by chance one in 462 is set apart in six rounds each.
  const auto all = [](double first, int rounds) {
    Results r;
    for (int q = 0; q < 400; ++q) {
      r.all.push_back({"tables", {fmt::format("{} mean", q), "ns", {}}});
      for (int i = 0; i < rounds; ++i) r.all.back().series.rounds.push_back(first + i);
    }
    r.all.push_back({"tables", {"one median", "ns", r.all.back().series.rounds}});
    return r;
  };
  EXPECT_EQ(roundsToJudge(all(100, 6)), 9u);
  for (const auto& [rounds, kind] : {std::pair{8, Change::Kind::kUnknown}, {9, Change::Kind::kWorse}}) {
    const std::vector<Change> changes = compare(all(100, rounds), all(150, rounds), {});
    ASSERT_EQ(changes.size(), 401u) << rounds;
    EXPECT_EQ(changes[0].kind, kind) << rounds;
    EXPECT_EQ(changes[400].kind, Change::Kind::kWorse) << "a median stands by itself";
  }
  EXPECT_EQ(roundsToJudge(one("ns", {1})), 6u);
}

TEST(CompareResults, MoreReadingsAreBetter) {
  EXPECT_EQ(verdict("Hz", {4000}, {1000}, {}, "device"), 'w');
  EXPECT_EQ(verdict("Hz", {1000}, {4000}, {}, "device"), 'b');
}

TEST(CompareResults, HashesAreShownWhole) {
  EXPECT_EQ(valueText("hash", 0x2A0123456789 + 0.0, 4), "2a0123456789");
  EXPECT_EQ(valueText("hash", 1, 4), "000000000001");
  EXPECT_EQ(valueText("N^2", 1.23456, 4), "1.235");
}

TEST(CompareResults, HashesOnlyWhereAskedFor) {
  EXPECT_EQ(verdict("hash", {5}, {6}), '-');
  EXPECT_EQ(verdict("hash", {5}, {6}, {true, true}), 'w');
  EXPECT_EQ(verdict("hash", {5}, {5}, {true, true}), '-');
}

TEST(CompareResults, WhatIsGoneIsNamed) {
  Results before = one("byte", {1});
  before.all.push_back({"b", {"gone", "ns", {1}}});
  const std::vector<Change> changes = compare(before, one("byte", {1}), {});
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].kind, Change::Kind::kMissing);
  EXPECT_EQ(changes[0].quantity, "gone");
}

TEST(CompareResults, TheLoadMakesNoOtherMachine) {
  Results a = one("ns", {1}), b = one("ns", {1});
  a.machine = {"cpu: x", "load: 0.10 0.20 0.30 1/80 1234", "build: y", "1000 triangles: built in 0.1 s"};
  b.machine = {"cpu: x", "load: 1.10 1.20 1.30 2/81 9876", "build: y"};
  EXPECT_TRUE(sameMachine(a, b));
  b.machine[2] = "build: z";
  EXPECT_FALSE(sameMachine(a, b));
}

TEST(CompareResults, WhatIsComparedIsKnownByItsUnit) {
  const auto isCompared = [](const std::string& unit, const Comparison& what) {
    return haptic_bench::isCompared(one(unit, {1}).all[0], what);
  };
  EXPECT_TRUE(isCompared("ns", {}));
  EXPECT_FALSE(isCompared("ns", {false, true}));
  EXPECT_FALSE(isCompared("hash", {}));
  EXPECT_TRUE(isCompared("N^2", {false, false}));
}

TEST(ReadResults, WhatWasPrintedIsRead) {
  const std::string name = "run sphere:radius=1,stacks=4 \"mine\"";
  const Results r =
      Results::parse("\xef\xbb\xbf# cpu: x\nbenchmark,quantity,unit,round,value\n" + csvField(name) +
                         ",a,ns,1,0.30000000000000004\n" + csvField(name) + ",a,ns,2,4\r\nother,a,s,1,5\n",
                     "t");
  ASSERT_EQ(r.all.size(), 2u);
  EXPECT_EQ(r.machine, std::vector<std::string>{"cpu: x"});
  EXPECT_EQ(r.all[0].benchmark, name);
  EXPECT_EQ(r.all[0].series.rounds, (std::vector<double>{0.1 + 0.2, 4}));
}

TEST(ReadResults, FaultsNameTheLine) {
  for (const char* text : {"a,b,ns,1\n", "a,b,ns,1,x\n", "a,b,ns,1,nan\n", "\"a,b,ns,1,2\n", "a,b,c,ns,1,2\n"}) {
    EXPECT_THAT([&] { (void)Results::parse(std::string("x,y,s,1,1\n") + text, "t"); },
                ThrowsMessage<Failure>(HasSubstr("t, line 2")))
        << text;
  }
  EXPECT_THROW((void)Results::parse("# nothing\n", "t"), Failure);
  EXPECT_THROW((void)Results::parse("a,b,s,1,1\na,b,s,1,1\n", "t"), Failure) << "a file twice";
  EXPECT_THROW((void)Results::parse("a,b,s,1,1\na,b,s,3,1\n", "t"), Failure) << "a line is gone";
  EXPECT_THROW((void)Results::parse("a,b,s,1,1\nc,d,s,1,1\na,b,s,1,1\n", "t"), Failure);
}

}  // namespace
}  // namespace haptic_bench
