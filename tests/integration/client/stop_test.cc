// A daemon is stopped while it works for its clients.
#include <gtest/gtest.h>

#include <atomic>
#include <hapticclient/hapticclient.hpp>
#include <thread>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

/** A square of n x n quads. */
struct Sheet {
  std::vector<float> vertices;
  std::vector<std::uint32_t> triangles;
  explicit Sheet(std::uint32_t n) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      for (std::uint32_t j = 0; j <= n; ++j)
        vertices.insert(vertices.end(), {1e-3F * static_cast<float>(i), 1e-3F * static_cast<float>(j), 0});
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::uint32_t j = 0; j < n; ++j) {
        const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
        triangles.insert(triangles.end(), {a, b, b + 1, a, b + 1, a + 1});
      }
    }
  }
};

TEST(Stopping, WhileAMeshIsBuiltIsAsClean) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  auto client = haptic::Client::connect({daemon.socket(), "loads"});
  ASSERT_TRUE(client);
  const Sheet sheet(400);
  std::atomic<bool> building{false}, over{false};
  int code = HAPTIC_OK;
  std::thread loads([&] {
    const auto report = [&](float, const char*) { return building = true; };
    code = client->scene().upload(sheet.vertices, sheet.triangles, 0, report).code();
    over = true;
  });
  EXPECT_TRUE(eventually([&] { return building || over; }));
  EXPECT_EQ(daemon.stop(), "") << daemon.log();
  loads.join();
  EXPECT_TRUE(building);
  EXPECT_EQ(code, HAPTIC_DISCONNECTED) << "0: it was built before it was stopped, make it larger";
}

TEST(Stopping, WhileDevicesAreArmedIsAsClean) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  auto client = haptic::Client::connect({daemon.socket(), "arms"});
  ASSERT_TRUE(client);
  auto session = client->openSession();
  ASSERT_TRUE(session);
  std::atomic<int> armed{0};
  std::atomic<bool> over{false};
  std::thread arms([&] {
    while (session->arm() && session->disarm()) ++armed;
    over = true;
  });
  EXPECT_TRUE(eventually([&] { return armed >= 20 || over; }));
  EXPECT_EQ(daemon.stop(), "") << daemon.log();
  arms.join();
  EXPECT_GE(armed, 20);
}

}  // namespace
}  // namespace hapticd::test
