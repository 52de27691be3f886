/** @file
 * A fake daemon and a client connected to it.
 */
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <hapticclient/hapticclient.hpp>
#include <memory>

#include "tests/support/eventually.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/unit/libclient/fake_daemon.h"

namespace hapticd::test {

class WithFakeDaemon : public ::testing::Test {
 protected:
  [[nodiscard]] std::string socket() const { return directory_.path() + "/control.sock"; }
  void start(Script script = {}) { daemon_ = std::make_unique<FakeDaemon>(socket(), std::move(script)); }
  /** The daemon dies and a new one takes its place. */
  void restart(std::uint64_t epoch) {
    daemon_ = nullptr;
    Script script;
    script.epoch = epoch;
    start(script);
  }
  [[nodiscard]] haptic::Result<haptic::Client> connect() {
    return haptic::Client::connect({socket(), "tester", false, std::chrono::seconds(10)});
  }

  test::TemporaryDirectory directory_;
  std::unique_ptr<FakeDaemon> daemon_;
};

class WithClient : public WithFakeDaemon {
 protected:
  void SetUp() override {
    start();
    auto client = connect();
    ASSERT_TRUE(client) << client.error().message();
    client_ = std::make_unique<haptic::Client>(std::move(*client));
  }
  std::unique_ptr<haptic::Client> client_;
};

class WithSession : public WithClient {
 protected:
  void SetUp() override {
    WithClient::SetUp();
    ASSERT_NE(client_, nullptr);
    auto session = client_->openSession();
    ASSERT_TRUE(session) << session.error().message();
    session_ = std::make_unique<haptic::Session>(std::move(*session));
  }
  std::unique_ptr<haptic::Session> session_;
};

/** Of so many newtons to the front, held for a millisecond. */
inline haptic_client_force force(double x) {
  haptic_client_force force{};
  force.lease_ns = 1'000'000;
  force.force[0] = x;
  return force;
}

}  // namespace hapticd::test
