/** @file
 * A client of the control socket in bare Cap'n Proto, so that the daemon is not tested with its own library.
 */
#pragma once

#include <capnp/rpc-twoparty.h>
#include <gtest/gtest.h>
#include <kj/async-io.h>
#include <sys/mman.h>

#include <memory>
#include <string>

#include "proto/control.capnp.h"
#include "proto/errors.h"
#include "proto/shm_layout.h"
#include "proto/snapshot.h"
#include "rt/base/error.h"

namespace hapticd::test {

/** The event loop of the test's thread. */
class Loop {
 public:
  Loop() = default;
  ~Loop() noexcept {}  // kj's destructors may throw; a fixture's may not
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;
  kj::AsyncIoContext io = kj::setupAsyncIo();
  template <class Request>
  auto call(Request request) {
    return request.send().wait(io.waitScope);
  }
  void pause(int ms) { io.provider->getTimer().afterDelay(ms * kj::MILLISECONDS).wait(io.waitScope); }
  /** Until `done()`, at most `seconds`. */
  template <class Done>
  bool until(Done done, int seconds = 60) {
    for (int i = 0; i < seconds * 200; ++i) {
      if (done()) return true;
      pause(5);
    }
    return done();
  }
};

/** One connection. */
class RawClient {
 public:
  RawClient(Loop& loop, const std::string& path)
      : stream(loop.io.provider->getNetwork()
                   .parseAddress(kj::str("unix:", path.c_str()))
                   .wait(loop.io.waitScope)
                   ->connect()
                   .wait(loop.io.waitScope)
                   .downcast<kj::AsyncCapabilityStream>()),
        network(*stream, 2, capnp::rpc::twoparty::Side::CLIENT),
        rpc(capnp::makeRpcClient(network)),
        daemon(bootstrap(rpc).castAs<proto::Daemon>()) {}
  ~RawClient() noexcept {}
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  kj::Own<kj::AsyncCapabilityStream> stream;
  capnp::TwoPartyVatNetwork network;
  capnp::RpcSystem<capnp::rpc::twoparty::VatId> rpc;
  proto::Daemon::Client daemon;

 private:
  static capnp::Capability::Client bootstrap(capnp::RpcSystem<capnp::rpc::twoparty::VatId>& rpc) {
    capnp::MallocMessageBuilder message(8);
    auto id = message.initRoot<capnp::rpc::twoparty::VatId>();
    id.setSide(capnp::rpc::twoparty::Side::SERVER);
    return rpc.bootstrap(id);
  }
};

/** A number of errors.h as its name, for readable failures. */
inline ErrorCode code(proto::Status::Reader status) { return static_cast<ErrorCode>(status.getCode()); }

inline ::testing::AssertionResult good(proto::Status::Reader status) {
  if (status.getCode() == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << status.getCode() << " " << status.getWhere().cStr() << ": "
                                       << status.getWhat().cStr() << " (" << status.getRemedy().cStr() << ")";
}

/** A mapping of a region that the daemon handed out. */
template <class T>
class Mapped {
 public:
  Mapped(Loop& loop, proto::Region::Client region, int protection) {
    auto fd = region.getFd().wait(loop.io.waitScope);
    KJ_IF_MAYBE (number, fd) {
      fd_ = dup(*number);
      void* memory = mmap(nullptr, sizeof(T), protection, MAP_SHARED, *number, 0);
      if (memory != MAP_FAILED) data_ = static_cast<T*>(memory);
    }
  }
  ~Mapped() {
    unmap();
    if (fd_ >= 0) close(fd_);
  }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  void unmap() {
    if (data_ != nullptr) munmap(data_, sizeof(T));
    data_ = nullptr;
  }
  [[nodiscard]] T* get() const { return data_; }
  T* operator->() const { return data_; }
  [[nodiscard]] int fd() const { return fd_; }

 private:
  T* data_ = nullptr;
  int fd_ = -1;
};

/** Asks for a session as a program does. */
inline auto openSession(Loop& loop, RawClient& client, const char* name, const char* uri = "") {
  auto request = client.daemon.openSessionRequest();
  request.setUri(uri);
  request.setClientName(name);
  request.setLayoutMajor(HD_SHM_MAJOR);
  request.setLayoutMinor(HD_SHM_MINOR);
  return loop.call(kj::mv(request));
}

/** A session with its regions mapped and the handshake done. */
struct LiveSession {
  LiveSession(Loop& loop, RawClient& client, const char* uri = "")
      : session([&] {
          auto answer = openSession(loop, client, "raw", uri);
          EXPECT_TRUE(good(answer.getStatus()));
          id = answer.getInfo().getId();
          return answer.getSession();
        }()) {
    auto regions = loop.call(session.regionsRequest());
    EXPECT_TRUE(good(regions.getStatus()));
    a = std::make_unique<Mapped<hd_region_a>>(loop, regions.getA(), PROT_READ);
    b = std::make_unique<Mapped<hd_region_b>>(loop, regions.getB(), PROT_READ | PROT_WRITE);
    EXPECT_NE(a->get(), nullptr);
    EXPECT_NE(b->get(), nullptr);
    EXPECT_TRUE(good(loop.call(session.mappedRequest()).getStatus()));
  }
  std::uint64_t id = 0;
  proto::Session::Client session;
  std::unique_ptr<Mapped<hd_region_a>> a;
  std::unique_ptr<Mapped<hd_region_b>> b;
};

}  // namespace hapticd::test
