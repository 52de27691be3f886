// What a user is refused: limits of what one may have, and what another may not do at all. The privileged case first.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <hapticclient/hapticclient.hpp>

#include "tests/integration/raw_client.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

constexpr uid_t kNobody = 65534;

class Refusal : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(daemon_.running()) << daemon_.log();
    // Others can reach the control socket; what refuses them is the daemon and the mode of the other socket.
    ASSERT_EQ(chmod(daemon_.directory().c_str(), 0755), 0);
  }
  void TearDown() override {
    if (HasFailure()) std::fputs(daemon_.log().c_str(), stderr);
  }
  static bool root() { return geteuid() == 0; }
  [[nodiscard]] std::ptrdiff_t descriptors() const {
    const std::filesystem::directory_iterator all("/proc/" + std::to_string(daemon_.pid()) + "/fd");
    return std::distance(begin(all), end(all));
  }
  haptic::Result<haptic::Client> connect(bool administration = false) const {
    return haptic::Client::connect({administration ? daemon_.adminSocket() : daemon_.socket(), "", administration});
  }
  static haptic_device_limits force(double newtons) { return {0, 0, newtons, NAN, NAN, NAN, NAN, NAN, NAN, NAN}; }
  /** Runs `check(complain)` as an unprivileged user; gives what it complained of. */
  template <class Check>
  std::string unprivileged(Check check) {
    if (!root()) {
      std::puts("[   NOTE   ] not root: the privileged half and other users' quotas are not tried, only the refusals");
      EXPECT_EQ(chmod(daemon_.adminSocket().c_str(), 0), 0) << "stands for a socket of another user";
    }
    ChildProcess child([&](auto say) {
      const auto complain = [&](bool right, const std::string& what) {
        if (!right) say(what + "; ");
      };
      complain(!root() || (setresgid(kNobody, kNobody, kNobody) == 0 && setresuid(kNobody, kNobody, kNobody) == 0),
               "dropping rights");
      complain(!root(), "it has no rights left");
      prctl(PR_SET_PDEATHSIG, SIGKILL);  // a change of user clears it
      check(complain);
    });
    return child.all();
  }

  DaemonFixture daemon_{{.program = HAPTICD_PROGRAM,
                         .config = "[sockets]\nmode = 0o666\n[quotas]\nsessions = 2\nmemory_mb = 4\n"
                                   "[guard]\narm_ramp_ms = 100\n"}};
};

TEST_F(Refusal, SessionsAndBytesOverTheSocketAreNamedWithTheirLimit) {
  Loop loop;
  RawClient client(loop, daemon_.socket());
  const auto open = [&] { return openSession(loop, client, "many"); };
  const auto begin = [&](std::uint64_t bytes) {
    auto request = loop.call(client.daemon.sceneRequest()).getScene().beginUploadRequest();
    request.setBytes(bytes);
    return loop.call(kj::mv(request));
  };
  const auto first = open();
  const auto second = open();
  ASSERT_TRUE(good(first.getStatus()));
  ASSERT_TRUE(good(second.getStatus()));
  const auto third = open();
  EXPECT_EQ(code(third.getStatus()), ErrorCode::kQuotaExceeded);
  EXPECT_NE(std::string(third.getStatus().getWhat().cStr()).find("2 sessions"), std::string::npos);

  const auto fits = begin(2'000'000);
  EXPECT_TRUE(good(fits.getStatus()));
  const auto over = begin(2'000'000);
  EXPECT_EQ(code(over.getStatus()), ErrorCode::kQuotaExceeded) << "two of them and the sessions are more than 4 MB";
  EXPECT_NE(std::string(over.getStatus().getWhat().cStr()).find("4000000 are allowed"), std::string::npos);
  for (const std::uint64_t absurd : {std::uint64_t{0}, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
    const auto refused = begin(absurd);
    EXPECT_EQ(code(refused.getStatus()), ErrorCode::kInvalidArgument) << absurd;
    EXPECT_NE(std::string(refused.getStatus().getWhat().cStr()).find("is not between"), std::string::npos);
  }
}

TEST_F(Refusal, WhoHoardsDescriptorsIsStopped) {
  Loop loop;
  RawClient client(loop, daemon_.socket());
  auto opened = openSession(loop, client, "greedy");
  ASSERT_TRUE(good(opened.getStatus()));
  auto ask = loop.call(client.daemon.sceneRequest()).getScene().beginUploadRequest();
  ask.setBytes(100'000);
  auto upload = loop.call(kj::mv(ask));
  ASSERT_TRUE(good(upload.getStatus()));
  const auto before = descriptors();
  std::vector<proto::Region::Client> held;
  const auto hoard = [&] {
    std::string refusal;
    for (int i = 0; i < 200; ++i) {
      auto regions = loop.call(opened.getSession().regionsRequest());
      if (good(regions.getStatus())) {
        held.push_back(regions.getA());
        held.push_back(regions.getB());
      }
      auto region = loop.call(upload.getUpload().regionRequest());
      if (good(region.getStatus())) {
        held.push_back(region.getRegion());
      } else {
        refusal = region.getStatus().getWhat().cStr();
      }
    }
    return refusal;
  };
  EXPECT_NE(hoard().find("holds 64 regions"), std::string::npos);
  EXPECT_EQ(held.size(), 64u);
  EXPECT_LE(descriptors(), before + 64);
  held.clear();
  EXPECT_TRUE(loop.until([&] { return descriptors() == before; }));
  EXPECT_NE(hoard().find("holds 64 regions"), std::string::npos) << "and it may have as many again";
  held.clear();

  std::vector<capnp::Response<proto::Scene::BeginUploadResults>> uploads;
  auto scene = loop.call(client.daemon.sceneRequest()).getScene();
  for (;;) {
    auto small = scene.beginUploadRequest();
    small.setBytes(1000);
    uploads.push_back(loop.call(kj::mv(small)));
    ASSERT_LE(uploads.size(), 100u);
    if (!good(uploads.back().getStatus())) break;
  }
  EXPECT_EQ(code(uploads.back().getStatus()), ErrorCode::kQuotaExceeded);
  EXPECT_NE(std::string(uploads.back().getStatus().getWhat().cStr()).find("16 uploads"), std::string::npos);
  uploads.clear();
  EXPECT_TRUE(loop.until([&] { return descriptors() == before; }));
}

TEST_F(Refusal, AdministrationAndRaisedLimitsAreNotForEverybody) {
  if (root()) {
    auto administrator = connect(true);
    ASSERT_TRUE(administrator) << administrator.error().message();
    ASSERT_TRUE(administrator->setLimits("sim", force(2)));
    const auto raised = administrator->setLimits("sim", force(3));
    ASSERT_TRUE(raised) << raised.error().message();
    EXPECT_EQ(raised->force, 3);
  }
  EXPECT_EQ(unprivileged([&](auto complain) {
              const auto refused = connect(true);
              complain(refused.code() == HAPTIC_PERMISSION_DENIED, "the administration socket lets it in");
              complain(refused.ok() || refused.error().where.find("admin.sock") != std::string::npos,
                       "the refusal does not name the socket: " + refused.error().message());
              auto client = connect();
              complain(client.ok(), "the control socket refuses it");
              auto session = client->openSession();
              complain(session.ok() && session->acquireLease().ok(), "it cannot have the lease");
              complain(client->setLimits("sim", force(1)).ok(), "its lease does not let it lower a limit");
              const auto raised = client->setLimits("sim", force(3));
              complain(raised.code() == HAPTIC_PERMISSION_DENIED, "it raises a limit");
              complain(client->statistics("sim", true).code() == HAPTIC_PERMISSION_DENIED, "it resets statistics");
              complain(client->closeDevice("sim").code() == HAPTIC_PERMISSION_DENIED, "it closes a device");
            }),
            "");
}

TEST_F(Refusal, AnotherUsersQuotaIsItsOwn) {
  auto client = connect();
  ASSERT_TRUE(client);
  auto first = client->openSession();
  auto second = client->openSession();
  ASSERT_TRUE(first);
  ASSERT_TRUE(second);
  const auto third = client->openSession();
  EXPECT_EQ(third.code(), HAPTIC_QUOTA_EXCEEDED);
  EXPECT_NE(third.error().message().find("user " + std::to_string(getuid()) + " has 2 sessions"), std::string::npos);
  const bool another = root();
  EXPECT_EQ(unprivileged([&](auto complain) {
              auto own = connect();
              complain(own.ok(), "the control socket refuses it");
              auto session = own->openSession();
              complain(session.ok() == another, "its quota is not its own");
              if (!another) return;
              auto more = own->openSession();
              complain(more.ok(), "its second session");
              const auto most = own->openSession();
              complain(most.code() == HAPTIC_QUOTA_EXCEEDED &&
                           most.error().message().find("user 65534 has 2 sessions") != std::string::npos,
                       "it has a quota, too");
            }),
            "");
}

TEST_F(Refusal, RegionsAreMappedAsOfferedAndNeverAfterwards) {
  const auto writable = [](int fd) {
    void* memory = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (memory == MAP_FAILED) return false;
    munmap(memory, 4096);
    return true;
  };
  // By its name in /proc as well: a new open file with rights of its own.
  const auto reopened = [&](int fd) {
    const int again = open(("/proc/self/fd/" + std::to_string(fd)).c_str(), O_RDWR | O_CLOEXEC);
    const bool can = again >= 0 && writable(again);
    if (again >= 0) close(again);
    return can;
  };
  const auto checks = [&](auto complain) {
    Loop loop;
    RawClient client(loop, daemon_.socket());
    auto opened = openSession(loop, client, "mapper");
    auto regions = loop.call(opened.getSession().regionsRequest());
    complain(good(regions.getStatus()), "no regions");
    Mapped<hd_region_a> a(loop, regions.getA(), PROT_READ);
    Mapped<hd_region_b> b(loop, regions.getB(), PROT_READ | PROT_WRITE);
    complain(a.get() != nullptr && b.get() != nullptr, "it cannot map what it is offered");
    complain(writable(b.fd()), "region B is not writable before it is sealed");
    complain(!writable(a.fd()) && !reopened(a.fd()), "region A is mapped writable");
    complain(good(loop.call(opened.getSession().mappedRequest()).getStatus()), "mapped");
    complain(!writable(b.fd()) && !reopened(b.fd()), "region B is mapped writable anew");
    void* readable = mmap(nullptr, 4096, PROT_READ, MAP_SHARED, b.fd(), 0);
    complain(readable != MAP_FAILED, "region B can be read");
    complain(mprotect(readable, 4096, PROT_READ | PROT_WRITE) != 0, "a readable mapping of B is made writable");
    for (const int fd : {a.fd(), b.fd()}) {
      complain(fallocate(fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096) != 0, "a hole is punched");
      complain(ftruncate(fd, 4096) != 0, "a region is cut");
      complain(pwrite(fd, "x", 1, 0) != 1, "a region is written as a file");
      complain(fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE) != 0, "seals are added");
    }
  };
  // Seals bind root, too: the same checks, with what is allowed before them.
  if (root()) {
    ChildProcess privileged([&](auto say) {
      checks([&](bool right, const std::string& what) {
        if (!right) say(what + "; ");
      });
    });
    EXPECT_EQ(privileged.all(), "");
  }
  EXPECT_EQ(unprivileged(checks), "");
}

}  // namespace
}  // namespace hapticd::test
