// What moves by itself, and is told again and again how fast.
#include <algorithm>

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

TEST(AVelocity, GivenAnewLeavesAnObjectOnItsWay) {
  constexpr double kV = 0.5, kStep = kV * 1e-3;  // In a tick [m].
  for (const int pause : {0, 1, 2, 5, 17}) {     // Ticks between two.
    SCOPED_TRACE(pause);
    Bench bench;
    ObjectSpec spec;
    spec.name = "bed";
    spec.shape = {ShapeKind::kBox, {0.1, 0.1, 0.1}, 0};
    spec.material = kDefaultMaterial;
    SceneModel& scene = bench.core.scene();
    const auto id = scene.create(spec, bench.core.client(bench.connection));
    ASSERT_TRUE(id.ok());
    const auto x = [&] {
      return bench.core.devices().links().front()->group().servo().cycle().scene().find(*id)->X_PO.p.x();
    };
    ASSERT_TRUE(scene.setVelocity("bed", {{kV, 0, 0}, {0, 0, 0}}).ok());
    bench.step(3);
    const double from = x();
    double before = from;
    int ticks = 0;
    for (int i = 0; i < 40; ++i) {
      ASSERT_TRUE(scene.setVelocity("bed", {{kV, 0, 0}, {0, 0, 0}}).ok());
      for (int k = 0; k <= pause; ++k, ++ticks) {
        bench.step();
        ASSERT_GE(x(), before) << "it goes back";
        before = x();
      }
    }
    EXPECT_NEAR(x() - from, ticks * kStep, 1.5 * kStep);
  }
}

}  // namespace
}  // namespace hapticd::test
