// What the collide thread could not do is told: by statistics, by resource, and by doctor with its remedy.
#include <capnp/message.h>

#include <nlohmann/json.hpp>

#include "daemon/resource/resource_tree.h"
#include "daemon/rpc/status.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

struct CollideCounts : testing::Test {
  void count(std::uint64_t queries, std::uint64_t exhausted, std::uint64_t unsent) {
    ColliderCounters& counters = bench.device().link->group().colliderCounters();
    counters.queries = queries;
    counters.exhausted = exhausted;
    counters.unsent = unsent;
  }
  CheckLine check() {
    for (const CheckLine& line : makeChecks(bench.core)) {
      if (line.name == "collision default") return line;
    }
    ADD_FAILURE() << "no check of it";
    return {};
  }
  Bench bench;
};

TEST_F(CollideCounts, AreInStatistics) {
  count(700, 20, 3);
  capnp::MallocMessageBuilder message;
  auto out = message.initRoot<proto::Statistics>();
  writeStatistics(out, bench.device());
  EXPECT_EQ(out.getCollideQueries(), 700u);
  EXPECT_EQ(out.getCollideExhausted(), 20u);
  EXPECT_EQ(out.getCollideUnsent(), 3u);
  ResourceTree tree(bench.core);
  const auto json = nlohmann::json::parse(*tree.get("/statistics/" + bench.device().name, {}));
  const nlohmann::json told{{"queries", 700}, {"exhausted", 20}, {"unsent", 3}};
  EXPECT_EQ(json["collide"], told);
}

TEST_F(CollideCounts, AreRedWhereTheyAreFelt) {
  using State = proto::Check::State;
  EXPECT_EQ(check().state, State::NOT_APPLICABLE);
  count(1000, 10, 10);
  EXPECT_EQ(check().state, State::GREEN) << "one in a hundred";
  count(1000, 11, 10);
  EXPECT_EQ(check().state, State::RED);
  EXPECT_NE(check().remedy.find("--voxel"), std::string::npos) << check().remedy;
  count(1000, 0, 11);
  EXPECT_EQ(check().state, State::RED);
  EXPECT_NE(check().detail.find("11 lost"), std::string::npos) << check().detail;
  EXPECT_NE(check().remedy.find("servo"), std::string::npos) << check().remedy;
}

}  // namespace
}  // namespace hapticd::test
