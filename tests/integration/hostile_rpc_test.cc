// Bad input for every method, and peers that do not play by the rules.
#include <capnp/any.h>
#include <capnp/rpc.capnp.h>
#include <capnp/serialize.h>
#include <malloc.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <filesystem>
#include <limits>

#include "daemon/rpc/question_limit.h"
#include "tests/integration/raw_client.h"
#include "tests/integration/running_daemon.h"

namespace hapticd::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::size_t openDescriptors() {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) count += entry.exists() ? 1 : 1;
  return count;
}

class Hostile : public ::testing::Test {
 protected:
  RunningDaemon daemon;
  Loop loop;
  RawClient client{loop, daemon.control()};

  bool serves() { return good(loop.call(client.daemon.stateRequest()).getStatus()); }
  int rawConnection() {
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    daemon.control().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
};

TEST_F(Hostile, BadTextsAreRefusedByEveryMethodThatTakesOne) {
  const std::string texts[] = {std::string(5000, 'a'),
                               std::string("a\nb"),
                               std::string("\xff\xfe"),
                               std::string("a\0b", 3),
                               std::string("\xed\xa0\x80"),
                               std::string("\xc0\xaf"),
                               std::string("\xc2\x9b"
                                           "31m")};
  auto scene = loop.call(client.daemon.sceneRequest()).getScene();
  for (const std::string& bad : texts) {
    const capnp::Text::Reader text(bad.data(), bad.size());
    const auto check = [&](auto request, auto set) {
      set(request);
      const ErrorCode got = code(loop.call(kj::mv(request)).getStatus());
      EXPECT_TRUE(got == ErrorCode::kInvalidArgument || got == ErrorCode::kNotFound) << static_cast<int>(got);
    };
    const auto uri = [&](auto& r) { r.setUri(text); };
    const auto name = [&](auto& r) { r.setName(text); };
    check(client.daemon.helloRequest(), [&](auto& r) {
      r.setClientName(text);
      r.setProtocolMajor(proto::PROTOCOL_MAJOR);
    });
    check(client.daemon.openDeviceRequest(), uri);
    check(client.daemon.closeDeviceRequest(), uri);
    check(client.daemon.openSessionRequest(), uri);
    check(client.daemon.openSessionRequest(), [&](auto& r) { r.setClientName(text); });
    check(client.daemon.getRequest(), [&](auto& r) { r.setPath(text); });
    check(client.daemon.setRequest(), uri);
    check(client.daemon.statisticsRequest(), uri);
    check(client.daemon.stopRequest(), uri);
    check(client.daemon.setLimitsRequest(), uri);
    check(scene.createRequest(), [&](auto& r) { r.initObject().setName(text); });
    check(scene.createRequest(), [&](auto& r) {
      r.initObject().setName("x");
      r.getObject().setParent(text);
    });
    check(scene.removeRequest(), name);
    check(scene.findRequest(), name);
    check(scene.setPoseRequest(), name);
    check(scene.setMaterialRequest(), name);
    check(scene.setFlagsRequest(), name);
    check(scene.setShapeRequest(), name);
  }
  EXPECT_TRUE(serves());
}

TEST_F(Hostile, EmptyRequestsOfEveryMethodGetAnAnswer) {
  auto scene = loop.call(client.daemon.sceneRequest()).getScene();
  EXPECT_EQ(code(loop.call(client.daemon.helloRequest()).getStatus()), ErrorCode::kVersionMismatch);
  EXPECT_EQ(code(loop.call(client.daemon.openSessionRequest()).getStatus()), ErrorCode::kVersionMismatch);
  EXPECT_EQ(code(loop.call(client.daemon.getRequest()).getStatus()), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(loop.call(client.daemon.setRequest()).getStatus()), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(loop.call(client.daemon.subscribeRequest()).getStatus()), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(loop.call(client.daemon.setLimitsRequest()).getStatus()), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(loop.call(scene.createRequest()).getStatus()), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(loop.call(scene.removeRequest()).getStatus()), ErrorCode::kNotFound);
  EXPECT_EQ(code(loop.call(scene.beginUploadRequest()).getStatus()), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(loop.call(scene.dropMeshRequest()).getStatus()), ErrorCode::kNotFound);
  auto kinds = client.daemon.subscribeRequest();
  kinds.setKinds(0xffffffff);
  EXPECT_EQ(code(loop.call(kj::mv(kinds)).getStatus()), ErrorCode::kInvalidArgument);
  EXPECT_TRUE(serves());
}

TEST_F(Hostile, BadNumbersChangeNothing) {
  auto scene = loop.call(client.daemon.sceneRequest()).getScene();
  auto create = scene.createRequest();
  create.initObject().setName("a");
  ASSERT_TRUE(good(loop.call(kj::mv(create)).getStatus()));
  for (const double bad : {kNaN, std::numeric_limits<double>::infinity(), -1e300}) {
    auto pose = scene.setPoseRequest();
    pose.setName("a");
    pose.initPose().initP().setX(bad);
    EXPECT_EQ(code(loop.call(kj::mv(pose)).getStatus()), ErrorCode::kInvalidArgument);
    auto turn = scene.setPoseRequest();
    turn.setName("a");
    turn.initPose().initQ().setY(bad);
    EXPECT_EQ(code(loop.call(kj::mv(turn)).getStatus()), ErrorCode::kInvalidArgument);
    auto material = scene.setMaterialRequest();
    material.setName("a");
    material.initMaterial().setStiffness(bad);
    EXPECT_EQ(code(loop.call(kj::mv(material)).getStatus()), ErrorCode::kInvalidArgument);
    auto shape = scene.setShapeRequest();
    shape.setName("a");
    shape.initShape().setKind(proto::ShapeKind::SPHERE);
    shape.getShape().initSize().setX(bad);
    EXPECT_EQ(code(loop.call(kj::mv(shape)).getStatus()), ErrorCode::kInvalidArgument);
  }
  auto odd = scene.setShapeRequest();
  odd.setName("a");
  odd.initShape().setKind(static_cast<proto::ShapeKind>(200));
  EXPECT_EQ(code(loop.call(kj::mv(odd)).getStatus()), ErrorCode::kInvalidArgument);
  auto find = scene.findRequest();
  find.setName("a");
  auto answer = loop.call(kj::mv(find));
  EXPECT_EQ(answer.getObject().getSpec().getPose().getP().getX(), 0.0);
  EXPECT_EQ(answer.getObject().getSpec().getShape().getKind(), proto::ShapeKind::GROUP);
}

TEST_F(Hostile, AMessageThatCannotBeReadIsNoDefectOfTheDaemons) {
  constexpr std::uint16_t kGet = 6;  // In control.capnp.
  auto structure = client.daemon.typelessRequest(capnp::typeId<proto::Daemon>(), kGet, nullptr);
  structure.initAsAnyStruct(0, 1).getPointerSection()[0].initAsAnyStruct(1, 0);  // Where a text is to be.
  auto list = client.daemon.typelessRequest(capnp::typeId<proto::Daemon>(), kGet, nullptr);
  list.initAsAnyStruct(0, 1).getPointerSection()[0].initAsAnyList(capnp::ElementSize::EIGHT_BYTES, 3);
  for (auto* request : {&structure, &list}) {
    const auto answer = loop.call(kj::mv(*request));
    const auto status = answer.getAs<proto::Daemon::GetResults>().getStatus();
    EXPECT_EQ(code(status), ErrorCode::kInvalidArgument);
    EXPECT_STREQ(status.getWhere().cStr(), "message");
  }
  EXPECT_TRUE(serves());
}

TEST_F(Hostile, NoExceptionTextCrosses) {
  // A message that is cut short makes the daemon's reader throw; the client may see that it failed, not how.
  const int fd = rawConnection();
  std::vector<std::uint64_t> junk(64, 0x4141414141414141);
  junk[0] = std::uint64_t{63} << 32;  // one segment of 63 words, all of it wild pointers
  ASSERT_GT(write(fd, junk.data(), junk.size() * 8), 0);
  shutdown(fd, SHUT_WR);
  std::string heard(1 << 16, 0);
  ssize_t n = 0;
  std::string all;
  while ((n = read(fd, heard.data(), heard.size())) > 0) all.append(heard.data(), static_cast<std::size_t>(n));
  close(fd);
  EXPECT_EQ(all.find("daemon/"), std::string::npos);
  EXPECT_EQ(all.find(".cc"), std::string::npos);
  EXPECT_TRUE(serves());
}

TEST_F(Hostile, GarbageHugeAndHalfMessagesEndOnlyTheirOwnConnection) {
  LiveSession live(loop, client);
  for (int round = 0; round < 20; ++round) {
    const int fd = rawConnection();
    std::string junk(4096, 0);
    for (std::size_t i = 0; i < junk.size(); ++i)
      junk[i] = static_cast<char>((i * 2654435761u + static_cast<unsigned>(round) * 40503u) >> 7);
    (void)!write(fd, junk.data(), junk.size());
    close(fd);
  }
  const int huge = rawConnection();
  const std::uint32_t header[2] = {0, 0x7fffffff};  // 16 GiB in one segment
  (void)!write(huge, header, sizeof header);
  const int half = rawConnection();
  (void)!write(half, header, 3);
  EXPECT_TRUE(serves());
  auto state = loop.call(client.daemon.stateRequest());
  EXPECT_EQ(state.getState().getClients().size(), 1u);
  close(huge);
  close(half);
}

/** Says what it likes, without the manners of Cap'n Proto's own client. */
class Rude {
 public:
  static constexpr std::uint16_t kScene = 5, kConfiguration = 13, kDump = 15;  ///< Numbers in control.capnp.

  explicit Rude(int fd) : fd_(fd) {
    capnp::MallocMessageBuilder message;
    message.initRoot<capnp::rpc::Message>().initBootstrap().setQuestionId(0);
    EXPECT_TRUE(send(message));
  }
  ~Rude() { close(fd_); }
  Rude(const Rude&) = delete;
  Rude& operator=(const Rude&) = delete;

  /** False: there is no room at the moment, or nobody any more. */
  bool call(std::uint32_t question, std::uint16_t method) {
    capnp::MallocMessageBuilder message;
    auto call = message.initRoot<capnp::rpc::Message>().initCall();
    call.setQuestionId(question);
    call.initTarget().initPromisedAnswer().setQuestionId(0);
    call.setInterfaceId(capnp::typeId<proto::Daemon>());
    call.setMethodId(method);
    call.initParams().getContent().initAs<proto::Daemon::ConfigurationParams>();
    call.getSendResultsTo().setCaller();
    return send(message);
  }
  bool finish(std::uint32_t question, bool release = true) {
    capnp::MallocMessageBuilder message;
    auto finish = message.initRoot<capnp::rpc::Message>().initFinish();
    finish.setQuestionId(question);
    finish.setReleaseResultCaps(release);
    return send(message);
  }
  /** How many bytes it has read. */
  std::size_t read() {
    std::string room(1 << 20, 0);
    ssize_t n = 0;
    while ((n = recv(fd_, room.data(), room.size(), MSG_DONTWAIT)) > 0) got_ += static_cast<std::size_t>(n);
    ended_ = n == 0 || (n < 0 && errno != EAGAIN);
    return got_;
  }
  [[nodiscard]] bool ended() const { return ended_; }

 private:
  bool send(capnp::MallocMessageBuilder& message) {
    if (unsent_.size() == 0) unsent_ = capnp::messageToFlatArray(message);
    const auto bytes = unsent_.asBytes().slice(sent_, unsent_.asBytes().size());
    const ssize_t n = ::send(fd_, bytes.begin(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n > 0) sent_ += static_cast<std::size_t>(n);
    if (n < static_cast<ssize_t>(bytes.size())) return false;
    unsent_ = nullptr;
    sent_ = 0;
    return true;
  }

  int fd_;
  kj::Array<capnp::word> unsent_;  ///< Until it has gone out whole the next call of send() goes on with it.
  std::size_t sent_ = 0, got_ = 0;
  bool ended_ = false;
};

/** Else the daemon would keep all that it does not read. */
TEST_F(Hostile, WhoReadsNoAnswersIsNotReadEither) {
  Rude rude(rawConnection());
  constexpr int kMost = 4000;  // Each answer has more than a kilobyte, a socket some hundreds.
  int sent = 0, refused = 0;
  while (sent < kMost && refused < 100) {
    if (rude.call(static_cast<std::uint32_t>(sent) + 1, Rude::kDump)) {
      ++sent;
      refused = 0;
    } else {
      ++refused;
      loop.pause(5);
    }
  }
  EXPECT_LT(sent, kMost) << "nothing was read by anybody";
  EXPECT_TRUE(serves()) << "others are";
  const std::size_t least = 1000 * static_cast<std::size_t>(sent);
  EXPECT_TRUE(loop.until([&] { return rude.read() > least; })) << "once it reads it is read";
}

/** Cap'n Proto keeps an answer until it is finished. */
TEST_F(Hostile, WhoFinishesNoAnswerIsCutOff) {
  Rude rude(rawConnection());
  const auto ask = [&](std::uint32_t questions, bool finish) {
    for (std::uint32_t i = 1; i <= questions && !rude.ended();) {
      if (rude.call(i, Rude::kConfiguration)) {
        while (finish && !rude.finish(i) && !rude.ended()) rude.read();
        ++i;
      }
      rude.read();
    }
  };
  const std::uint32_t most = QuestionLimit::kMostOpen;
  ask(3 * most, true);
  EXPECT_FALSE(rude.ended()) << "who finishes them may ask as often as it likes";
  ask(most - 1, false);  // The first is the capability that all are asked of.
  loop.pause(100);
  rude.read();
  EXPECT_FALSE(rude.ended()) << "so many may be held";
  const auto patiently = [&] {  // While it has answers to get rid of it reads nothing.
    rude.read();
    return rude.call(most, Rude::kConfiguration);
  };
  EXPECT_TRUE(loop.until(patiently));
  EXPECT_TRUE(loop.until([&] {
    rude.read();
    return rude.ended();
  }));
  EXPECT_TRUE(serves()) << "others stay";
  std::vector<int> others;  // With these and the fixture's there would be 64 before the next.
  for (int i = 0; i < 62; ++i) others.push_back(rawConnection());
  RawClient last{loop, daemon.control()};
  EXPECT_TRUE(good(loop.call(last.daemon.stateRequest()).getStatus())) << "it keeps no place, although it stays";
  for (const int fd : others) close(fd);
}

/** Nor is there a new capability for each time that somebody asks for the one scene. */
TEST_F(Hostile, WhoReleasesNoSceneHoldsOne) {
  constexpr std::uint32_t kCalls = 20'000;
  Rude rude(rawConnection());
  const auto held = [] {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
  };
  ASSERT_TRUE(serves());
  const std::size_t before = held();
  for (std::uint32_t i = 1; i <= kCalls; ++i) {
    const auto patiently = [&](auto send) {
      return loop.until([&] {
        rude.read();
        return send();
      });
    };
    ASSERT_TRUE(patiently([&] { return rude.call(i, Rude::kScene); }));
    ASSERT_TRUE(patiently([&] { return rude.finish(i, false); }));
  }
  std::size_t after = 0;
  EXPECT_TRUE(loop.until([&] { return (after = held()) < before + kCalls * 16; })) << after - before << " bytes more";
  EXPECT_FALSE(rude.ended());
}

TEST_F(Hostile, SentDescriptorsAreClosed) {
  ASSERT_TRUE(serves());
  const std::size_t before = openDescriptors();
  const int fd = rawConnection();
  for (int round = 0; round < 40; ++round) {
    char byte[8] = {};
    iovec data{byte, sizeof byte};
    int gift[20];
    for (int& g : gift) g = 0;
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof gift)] = {};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof gift);
    std::memcpy(CMSG_DATA(header), gift, sizeof gift);
    if (sendmsg(fd, &message, MSG_NOSIGNAL) < 0) break;
    EXPECT_TRUE(serves());
  }
  close(fd);
  EXPECT_TRUE(loop.until([&] { return serves() && openDescriptors() <= before; }))
      << openDescriptors() << " > " << before;
}

TEST_F(Hostile, AFloodOfSubscriptionsIsBoundedPerUserAndLeavesAdministratorsTheirs) {
  class Deaf final : public proto::EventListener::Server {};
  const auto subscribe = [&](RawClient& by) {
    auto request = by.daemon.subscribeRequest();
    request.setListener(kj::heap<Deaf>());
    return loop.call(kj::mv(request));
  };
  using Answer = capnp::Response<proto::Daemon::SubscribeResults>;
  std::vector<Answer> held;
  for (int i = 0; i < 64; ++i) held.push_back(subscribe(client));
  EXPECT_TRUE(good(held.back().getStatus()));
  RawClient another{loop, daemon.control()}, administrator{loop, daemon.admin()};
  EXPECT_EQ(code(subscribe(another).getStatus()), ErrorCode::kQuotaExceeded);
  EXPECT_TRUE(good(subscribe(administrator).getStatus()));
  held.pop_back();
  EXPECT_TRUE(loop.until([&] { return static_cast<bool>(good(subscribe(another).getStatus())); }));
}

TEST_F(Hostile, AFloodOfConnectionsIsBoundedPerUser) {
  std::vector<int> held;
  for (int i = 0; i < 100; ++i) held.push_back(rawConnection());
  int refused = 0;
  EXPECT_TRUE(loop.until([&] {
    refused = 0;
    for (const int fd : held) {
      char byte = 0;
      refused += recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0 ? 1 : 0;  // closed by the daemon
    }
    return refused == 100 - 64 + 1 - 4;  // Beyond 64 four may come to stop devices.
  })) << refused;
  EXPECT_TRUE(serves());
  for (const int fd : held) close(fd);
  EXPECT_TRUE(loop.until([&] {
    RawClient again{loop, daemon.control()};
    try {
      return static_cast<bool>(good(loop.call(again.daemon.stateRequest()).getStatus()));
    } catch (const kj::Exception&) {
      return false;  // not yet
    }
  }));
}

TEST_F(Hostile, ASessionNobodyMapsIsTakenBack) {
  auto request = client.daemon.openSessionRequest();
  request.setLayoutMajor(HD_SHM_MAJOR);
  request.setLayoutMinor(HD_SHM_MINOR);
  request.setClientName("half");
  auto open = loop.call(kj::mv(request));
  ASSERT_TRUE(good(open.getStatus()));
  EXPECT_EQ(loop.call(client.daemon.stateRequest()).getState().getClients().size(), 1u);
  { auto dropped = open.getSession(); }
  open = loop.call(client.daemon.openSessionRequest());  // the old answer held the capability
  EXPECT_TRUE(loop.until([&] { return loop.call(client.daemon.stateRequest()).getState().getClients().size() == 0; }));
}

}  // namespace
}  // namespace hapticd::test
