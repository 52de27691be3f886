#include "tests/mix/rude_peer.h"

#include <capnp/any.h>
#include <capnp/rpc.capnp.h>
#include <capnp/serialize.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tests/integration/raw_client.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

class RudePeer {
 public:
  RudePeer(const std::string& path, std::uint32_t seed) : random_(seed), fd_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    (void)!connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    capnp::MallocMessageBuilder first;
    first.initRoot<capnp::rpc::Message>().initBootstrap().setQuestionId(0);
    send(capnp::messageToFlatArray(first).asBytes());
    call(1, 0, capnp::typeId<proto::Daemon>(), 5);  // The scene: what calls of question 1 are made to.
  }
  ~RudePeer() { close(fd_); }
  RudePeer(const RudePeer&) = delete;
  RudePeer& operator=(const RudePeer&) = delete;

  void step() {
    const std::uint32_t question = random_.once(20) ? random_.below(40u) : next_++;
    switch (random_.below(12)) {
      case 0:
        return finish(random_.below(next_));
      case 1:
        return other();
      case 2:
        return junk();
      case 3:
        return read();
      case 4:
      case 5:
      case 6:
        return call(question, 1, capnp::typeId<proto::Scene>(), random_.below(std::uint16_t{17}));
      case 7:
        return call(question, random_.below(next_), anyInterface(), random_.below(std::uint16_t{20}));
      default:
        return call(question, 0, capnp::typeId<proto::Daemon>(), random_.below(std::uint16_t{19}));
    }
  }

 private:
  std::uint64_t anyInterface() {
    const std::uint64_t all[] = {capnp::typeId<proto::Session>(), capnp::typeId<proto::Upload>(),
                                 capnp::typeId<proto::Recording>(), capnp::typeId<proto::Region>(), random_.bits()};
    return all[random_.below(std::size(all))];
  }

  /** Of the answer's first pointers, one that may be a capability. */
  void call(std::uint32_t question, std::uint32_t to, std::uint64_t interface, std::uint16_t method) {
    capnp::MallocMessageBuilder message;
    auto call = message.initRoot<capnp::rpc::Message>().initCall();
    call.setQuestionId(question);
    auto target = call.initTarget().initPromisedAnswer();
    target.setQuestionId(to);
    if (to != 0) target.initTransform(1)[0].setGetPointerField(to == 1 ? 1 : random_.below(std::uint16_t{4}));
    call.setInterfaceId(interface);
    call.setMethodId(method);
    auto params = call.initParams();
    auto content =
        params.initContent().initAsAnyStruct(random_.below(std::uint16_t{12}), random_.below(std::uint16_t{4}));
    fill(content, 0);
    if (random_.once(2)) {
      auto table = params.initCapTable(1 + random_.below(3u));
      for (auto entry : table) {
        if (random_.once(3)) continue;
        if (random_.once(2)) {
          entry.setSenderHosted(random_.below(5u));
        } else {
          entry.setReceiverHosted(random_.below(5u));
        }
      }
    }
    call.getSendResultsTo().setCaller();
    send(turned(message));
  }

  void fill(capnp::AnyStruct::Builder content, int depth) {
    for (capnp::byte& each : content.getDataSection()) {
      if (random_.once(2)) each = static_cast<capnp::byte>(random_.bits());
    }
    static const char* const kTexts[] = {"",
                                         "a",
                                         "sim",
                                         "sim2",
                                         "sim://default",
                                         "/objects/a/pos?value=1,2,3",
                                         "/devices",
                                         "/devices/sim/tool?value=a",
                                         "\xff\xfe",
                                         "/objects/%00/x"};
    auto pointers = content.getPointerSection();
    for (unsigned i = 0; i < pointers.size(); ++i) {
      auto pointer = pointers[i];
      switch (random_.below(5)) {
        case 0:
          break;
        case 1:
          if (depth < 3)
            fill(pointer.initAsAnyStruct(random_.below(std::uint16_t{8}), random_.below(std::uint16_t{4})), depth + 1);
          break;
        case 2:
          pointer.initAsAnyList(static_cast<capnp::ElementSize>(random_.below(6)), random_.below(50u));
          break;
        default:
          pointer.setAs<capnp::Text>(kTexts[random_.below(std::size(kTexts))]);
      }
    }
  }

  void finish(std::uint32_t question) {
    capnp::MallocMessageBuilder message;
    auto finish = message.initRoot<capnp::rpc::Message>().initFinish();
    finish.setQuestionId(question);
    finish.setReleaseResultCaps(random_.once(2));
    send(turned(message));
  }

  void other() {
    capnp::MallocMessageBuilder message;
    auto root = message.initRoot<capnp::rpc::Message>();
    switch (random_.below(5)) {
      case 0: {
        auto release = root.initRelease();
        release.setId(random_.below(6u));
        release.setReferenceCount(random_.below(4u));
        break;
      }
      case 1:
        root.initReturn().setAnswerId(random_.below(6u));
        break;
      case 2:
        root.initDisembargo().initTarget().setImportedCap(random_.below(6u));
        break;
      case 3:
        root.initResolve().setPromiseId(random_.below(6u));
        break;
      default:
        root.initBootstrap().setQuestionId(next_++);
    }
    send(turned(message));
  }

  void junk() {
    std::uint64_t words[16];
    for (std::uint64_t& word : words) word = random_.once(3) ? 0 : random_.bits();
    if (random_.once(30)) send({reinterpret_cast<const kj::byte*>(words), sizeof words});
  }

  void read() {
    char room[65536];
    while (recv(fd_, room, sizeof room, MSG_DONTWAIT) > 0) continue;
  }

  /** One in six with some bits turned behind its header. */
  kj::Array<kj::byte> turned(capnp::MessageBuilder& message) {
    const auto words = capnp::messageToFlatArray(message);
    auto bytes = kj::heapArray<kj::byte>(words.asBytes());
    if (!random_.once(6)) return bytes;
    for (int i = 1 + random_.below(4); i > 0; --i)
      bytes[8 + random_.below(bytes.size() - 8)] ^= static_cast<kj::byte>(1u << random_.below(8));
    return bytes;
  }

  void send(kj::ArrayPtr<const kj::byte> bytes) {
    const std::size_t size = random_.once(300) ? random_.below(bytes.size()) : bytes.size();
    for (std::size_t sent = 0; sent < size;) {
      const ssize_t n = ::send(fd_, bytes.begin() + sent, size - sent, MSG_DONTWAIT | MSG_NOSIGNAL);
      if (n < 0 && errno != EAGAIN) return;
      if (n < 0) read();
      sent += n < 0 ? 0 : static_cast<std::size_t>(n);
    }
  }
  void send(const kj::Array<kj::byte>& bytes) { send(bytes.asPtr()); }

  Random random_;
  int fd_;
  std::uint32_t next_ = 2;
};

}  // namespace

void beRude(const std::string& socket, std::uint32_t seed) {
  Random random(seed);
  for (int peers = 1 + random.below(6); peers > 0; --peers) {
    RudePeer peer(socket, seed + static_cast<std::uint32_t>(peers));
    for (int left = random.below(200); left > 0; --left) peer.step();
    std::this_thread::sleep_for(std::chrono::milliseconds(random.below(50)));
  }
}

void scribble(const std::string& socket, std::uint32_t seed) try {
  Loop loop;
  RawClient raw(loop, socket);
  auto answer = openSession(loop, raw, "scribbler");
  if (code(answer.getStatus()) != ErrorCode::kOk) return;
  auto session = answer.getSession();
  auto regions = loop.call(session.regionsRequest());
  const Mapped<hd_region_b> b(loop, regions.getB(), PROT_READ | PROT_WRITE);
  if (b.get() == nullptr || code(loop.call(session.mappedRequest()).getStatus()) != ErrorCode::kOk) return;
  Random random(seed);
  auto* const words = reinterpret_cast<volatile std::uint64_t*>(b.get());
  for (;;) {
    const std::size_t at = random.below(sizeof(hd_region_b) / sizeof(std::uint64_t));
    words[at] = random.once(2) ? random.below(std::uint64_t{9}) : random.bits();
    if (random.once(1000)) loop.pause(1);
  }
} catch (const kj::Exception&) {  // The daemon has hung up.
}

}  // namespace hapticd::test
