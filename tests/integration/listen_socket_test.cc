// A daemon's own socket file, and what becomes of it.
#include "daemon/rpc/listen_socket.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/process/no_descriptors.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/** As in a folder whose rights were taken away; here a link that leads to itself, which stops root, too. */
TEST(ListenSocket, WhatCannotBeLookedAtIsNotLost) {
  const TemporaryDirectory directory;
  const fs::path folder = directory.path() + "/run", aside = directory.path() + "/aside";
  auto socket = ListenSocket::bind(folder.string() + "/control.sock", 0600, {});
  ASSERT_TRUE(socket.ok()) << toString(socket.error());
  EXPECT_FALSE(socket->lost());
  fs::rename(folder, aside);
  EXPECT_TRUE(socket->lost());
  fs::create_directory_symlink(folder, folder);
  EXPECT_FALSE(socket->lost());
  fs::remove(folder);
  fs::rename(aside, folder);
  EXPECT_FALSE(socket->lost()) << "it is found again";
  const auto second = ListenSocket::bind(folder.string() + "/control.sock", 0600, {});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kAlreadyExists) << "its lock was never let go of";
}

TEST(ListenSocket, WhatHasRunOutIsNoWantOfRights) {
  const TemporaryDirectory directory;
  const NoDescriptors none;
  const auto socket = ListenSocket::bind(directory.path() + "/control.sock", 0600, {});
  ASSERT_FALSE(socket.ok());
  EXPECT_NE(socket.error().remedy.find("LimitNOFILE"), std::string::npos) << socket.error().remedy;
}

}  // namespace
}  // namespace hapticd::test
