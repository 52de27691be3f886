// A recording's stream on its way into a file, whose disk is slow, full or quick.
#include "tools/hapticctl/file/carrier.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>

namespace hapticctl {
namespace {

/** A stream, and a disk that takes what is written at once and holds up each sync until it is let go. */
class CarrierTest : public testing::Test {
 protected:
  CarrierTest() { EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0); }
  ~CarrierTest() override {
    hangUp();
    ::close(ends[1]);
  }

  void hangUp() {
    if (ends[0] >= 0) ::close(ends[0]);
    ends[0] = -1;
  }

  Carrier::Target disk() {
    return {[this](const char* data, std::size_t size) {
              const std::lock_guard lock(mutex);
              if (full) return ENOSPC;
              written.append(data, size);
              return 0;
            },
            [this] {
              std::unique_lock lock(mutex);
              ++syncs;
              changed.notify_all();
              changed.wait(lock, [this] { return !slow; });
              return 0;
            }};
  }

  /** As the daemon sends: whether there was room in the stream within two seconds. */
  bool send(const std::string& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n = ::send(ends[0], bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n > 0) sent += static_cast<std::size_t>(n);
      if (n < 0 && errno != EAGAIN) return false;
      pollfd writable{ends[0], POLLOUT, 0};
      if (n < 0 && ::poll(&writable, 1, 2000) != 1) return false;
    }
    return true;
  }

  void letGo() {
    const std::lock_guard lock(mutex);
    slow = false;
    changed.notify_all();
  }

  int ends[2] = {-1, -1};
  std::mutex mutex;
  std::condition_variable changed;
  std::string written;
  int syncs = 0;
  bool slow = false, full = false;
};

/** No piece is like another, so that what arrives otherwise than it was sent is seen. */
std::string bytesOf(std::size_t size, unsigned seed) {
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>((i * 2654435761u + seed) >> 13);
  return bytes;
}

TEST_F(CarrierTest, TheStreamIsReadOnWhileASyncHangs) {
  slow = true;
  Carrier carrier(ends[1], disk());
  std::string all;
  bool every = true;
  {
    std::unique_lock lock(mutex);
    while (syncs == 0) {  // Until one hangs.
      lock.unlock();
      const std::string some = bytesOf(1000, static_cast<unsigned>(all.size()));
      ASSERT_TRUE(send(some));
      all += some;
      lock.lock();
      changed.wait_for(lock, std::chrono::milliseconds(20), [this] { return syncs > 0; });
    }
  }
  for (unsigned i = 0; i < 40 && every; ++i) {  // Far more than a socket holds.
    const std::string some = bytesOf(1'000'003, i);
    every = send(some);
    all += some;
  }
  EXPECT_TRUE(every) << "the stream stood still";
  letGo();
  hangUp();
  carrier.join();
  EXPECT_EQ(carrier.problem(), 0);
  EXPECT_TRUE(carrier.over());
  EXPECT_TRUE(written == all) << written.size() << " of " << all.size();
}

TEST_F(CarrierTest, MoreThanItsRoomArrivesWhole) {
  Carrier carrier(ends[1], disk());
  const std::string piece = bytesOf((std::size_t{1} << 20) + 7, 1);
  constexpr int kPieces = 70;
  for (int i = 0; i < kPieces; ++i) ASSERT_TRUE(send(piece));
  hangUp();
  carrier.join();
  ASSERT_EQ(written.size(), kPieces * piece.size());
  for (int i = 0; i < kPieces; ++i) ASSERT_EQ(written.compare(i * piece.size(), piece.size(), piece), 0) << i;
}

/** Of a daemon that hangs: it would never come. */
TEST_F(CarrierTest, AStreamWithoutAnEndIsLeftAndWhatCameIsWritten) {
  slow = true;
  Carrier carrier(ends[1], disk());
  const std::string all = bytesOf(3'000'000, 3);
  ASSERT_TRUE(send(all));
  letGo();
  carrier.end(std::chrono::milliseconds(50));
  EXPECT_TRUE(carrier.over());
  EXPECT_EQ(carrier.problem(), 0);
  EXPECT_TRUE(written == all) << written.size();
}

TEST_F(CarrierTest, AFullDiskIsToldAndTheStreamTakesNoMore) {
  full = true;
  Carrier carrier(ends[1], disk());
  ASSERT_TRUE(send("some"));
  carrier.join();
  EXPECT_EQ(carrier.problem(), ENOSPC);
  EXPECT_TRUE(carrier.over());
  EXPECT_FALSE(send("more"));
  EXPECT_EQ(written, "");
}

}  // namespace
}  // namespace hapticctl
