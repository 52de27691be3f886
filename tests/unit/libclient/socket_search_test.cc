#include "libclient/src/connection/socket_search.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <vector>

namespace hapticd::client {
namespace {

using Paths = std::vector<std::string>;

TEST(SocketSearch, WhatTheProgramGivesIsTakenAsItIs) {
  EXPECT_EQ(candidates({"/a/b.sock", "/env/control.sock", "/run/user/1", false}), Paths{"/a/b.sock"});
  EXPECT_EQ(candidates({"/a/b.sock", "/env/control.sock", "/run/user/1", true}), Paths{"/a/b.sock"});
}

TEST(SocketSearch, TheEnvironmentComesNextAndAlone) {
  EXPECT_EQ(candidates({"", "/env/my.sock", "/run/user/1", false}), Paths{"/env/my.sock"});
  EXPECT_EQ(candidates({"", "/env/my.sock", "/run/user/1", true}), Paths{"/env/admin.sock"});
  EXPECT_EQ(candidates({"", "my.sock", "", true}), Paths{"admin.sock"});
}

TEST(SocketSearch, TheUsersDaemonBeforeTheSystems) {
  EXPECT_EQ(candidates({"", "", "/run/user/1", false}),
            (Paths{"/run/user/1/hapticd/control.sock", "/run/hapticd/control.sock"}));
  EXPECT_EQ(candidates({"", "", "/run/user/1", true}),
            (Paths{"/run/user/1/hapticd/admin.sock", "/run/hapticd/admin.sock"}));
  EXPECT_EQ(candidates({"", "", "", false}), Paths{"/run/hapticd/control.sock"});
}

TEST(SocketSearch, APathThatIsTooLongIsNamed) {
  OwnDescriptor fd;
  const std::string path(200, 'x');
  const Failure failure = connectTo(path, 0, fd);
  EXPECT_EQ(failure.code, HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(failure.where, path);
  EXPECT_EQ(fd.get(), -1);
}

TEST(SocketSearch, AFileThatIsNoSocketIsCalledThat) {
  char path[] = "/tmp/hapticd-no-socket.XXXXXX";
  const int file = mkstemp(path);
  ASSERT_GE(file, 0);
  OwnDescriptor fd;
  const Failure failure = connectTo(path, 0, fd);
  EXPECT_EQ(failure.code, HAPTIC_DISCONNECTED);
  EXPECT_EQ(failure.what, "is not a socket");
  EXPECT_EQ(fd.get(), -1);
  close(file);
  unlink(path);
}

TEST(SocketSearch, OfAFolderTheSocketInItIsMeant) {
  OwnDescriptor fd;
  const Failure failure = connectTo("/tmp", 0, fd);
  EXPECT_EQ(failure.code, HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(failure.what, "is a folder");
  EXPECT_EQ(failure.remedy, "name the socket in it: /tmp/control.sock");
  EXPECT_EQ(fd.get(), -1);
}

TEST(SocketSearch, AFailedSearchNamesEveryPathAndItsReason) {
  const Failure failure =
      nobodyAnswers({"/a", "/b"}, {{HAPTIC_DISCONNECTED, "/a", "no such socket", {}},
                                   {HAPTIC_PERMISSION_DENIED, "/b", "you may not connect", "join the group haptic"}});
  EXPECT_EQ(failure.code, HAPTIC_PERMISSION_DENIED);
  EXPECT_EQ(failure.where, "/a, /b");
  EXPECT_EQ(failure.what, "/a: no such socket; /b: you may not connect");
  EXPECT_EQ(failure.remedy, "join the group haptic");
  const Failure none{HAPTIC_DISCONNECTED, "/a", "no such socket", {}};
  EXPECT_EQ(nobodyAnswers({"/a", "/b"}, {none, none}).what, "no such socket") << "where names them";
  EXPECT_EQ(nobodyAnswers({"/a", "/b"}, {none, none}).where, "/a, /b");
  const Failure late{HAPTIC_TIMEOUT, "/a", "no answer within 50 ms", "see whether hapticd runs: hapticctl doctor"};
  EXPECT_EQ(nobodyAnswers({"/a", "/b"}, {late, none}).code, HAPTIC_TIMEOUT) << "there is a daemon";
  EXPECT_EQ(nobodyAnswers({"/a", "/b"}, {late, none}).remedy, late.remedy);
  const Failure impossible{HAPTIC_INVALID_ARGUMENT, "/a", "is longer than a socket path can be", "use a shorter path"};
  EXPECT_EQ(nobodyAnswers({"/a", "/b"}, {impossible, none}).code, HAPTIC_DISCONNECTED);
  EXPECT_NE(nobodyAnswers({"/a", "/b"}, {impossible, none}).remedy, impossible.remedy) << "the program gave no path";
  const Failure full{HAPTIC_SYSTEM, "/a", "no socket can be made: Too many open files", "close some descriptors"};
  EXPECT_EQ(nobodyAnswers({"/a", "/b"}, {full, full}).code, HAPTIC_SYSTEM);
  EXPECT_EQ(nobodyAnswers({"/a"}, {impossible}).code, HAPTIC_INVALID_ARGUMENT) << "here it did";
}

}  // namespace
}  // namespace hapticd::client
