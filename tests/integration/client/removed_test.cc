// Somebody removes a running daemon's sockets.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <hapticclient/hapticclient.hpp>
#include <string>

#include "tests/support/eventually.h"
#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

/** By a program that ends by itself. */
std::string said(const std::string& command) {
  std::string text;
  FILE* const out = ::popen(command.c_str(), "r");
  for (int c = 0; out != nullptr && (c = std::fgetc(out)) != EOF;) text += static_cast<char>(c);
  if (out != nullptr) ::pclose(out);
  return text;
}

TEST(RemovedSockets, AreMadeAnewAndWhoIsConnectedStays) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  const auto connects = [&](bool administration) {
    const std::string path = administration ? daemon.adminSocket() : daemon.socket();
    const auto client = haptic::Client::connect({path, "late", administration});
    return client.ok() && (*client->daemon())->administration == (administration ? 1u : 0u);
  };
  const auto mode = [](const std::string& path) { return std::filesystem::status(path).permissions(); };
  const auto before = mode(daemon.socket());
  const std::string list = daemon.socket().substr(0, daemon.socket().rfind('/')) + "/armed";
  auto first = haptic::Client::connect({daemon.socket(), "early"});
  ASSERT_TRUE(first);
  const auto descriptors = [&] {
    const std::filesystem::directory_iterator all("/proc/" + std::to_string(daemon.pid()) + "/fd");
    return std::distance(begin(all), end(all));
  };
  const auto open_before = descriptors();
  for (int round = 0; round < 2; ++round) {
    for (const std::string& path : {daemon.socket(), daemon.adminSocket()}) std::filesystem::remove(path);
    if (round == 1) std::filesystem::remove(daemon.socket() + ".lock");
    EXPECT_TRUE(std::filesystem::remove(list));
    EXPECT_TRUE(eventually([&] { return connects(false) && connects(true); })) << daemon.log();
    EXPECT_EQ(mode(daemon.socket()), before);
    EXPECT_TRUE(eventually([&] { return std::filesystem::exists(list); })) << "of armed devices, for hapticd-safe";
  }
  EXPECT_TRUE(first->status()) << "by the connection it had";
  EXPECT_TRUE(eventually([&] { return descriptors() <= open_before; })) << descriptors() << ", not " << open_before;
  EXPECT_NE(daemon.log().find(daemon.socket() + " was removed: it is made anew"), std::string::npos);
  EXPECT_NE(said("timeout 20 " HAPTICD_PROGRAM " --allow-no-rt --socket " + daemon.socket() + " 2>&1")
                .find("another hapticd (pid " + std::to_string(daemon.pid()) + ") serves this socket"),
            std::string::npos);
  EXPECT_EQ(daemon.stop(), "");
  for (const std::string& path : {daemon.socket(), daemon.adminSocket(), daemon.socket() + ".lock"})
    EXPECT_FALSE(std::filesystem::exists(path)) << path;
}

}  // namespace
}  // namespace hapticd::test
