/** @file
 * A daemon of a test's own and one program that makes things in it.
 */
#pragma once

#include <gtest/gtest.h>

#include <hapticclient/hapticclient.hpp>
#include <optional>
#include <utility>

#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {

class Maker : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(daemon_.running()) << daemon_.log();
    auto client = haptic::Client::connect({daemon_.socket(), "maker"});
    ASSERT_TRUE(client) << client.error().message();
    client_.emplace(std::move(*client));
  }

  DaemonFixture daemon_{{.program = HAPTICD_PROGRAM}};
  std::optional<haptic::Client> client_;
};

}  // namespace hapticd::test
