#include "daemon/ipc/memfd.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>

namespace hapticd {
namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kBytes = 8 * kPage;

Memfd make() {
  auto memfd = Memfd::create("test", kBytes);
  EXPECT_TRUE(memfd.ok()) << toString(memfd.error());
  return std::move(*memfd);
}

int punchHole(const Memfd& memfd) {
  return ::fallocate(memfd.fd(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, kPage) == 0 ? 0 : errno;
}
int madviseRemove(const Mapping& mapping) { return ::madvise(mapping.data(), kPage, MADV_REMOVE) == 0 ? 0 : errno; }
int truncateTo(const Memfd& memfd, off_t bytes) { return ::ftruncate(memfd.fd(), bytes) == 0 ? 0 : errno; }

TEST(Memfd, StartsUnsealedAndZero) {
  const Memfd memfd = make();
  EXPECT_TRUE(memfd.requireSeals(Seals::kNone).ok());
  EXPECT_EQ(::fcntl(memfd.fd(), F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
  auto mapping = memfd.map(Memfd::Access::kRead);
  ASSERT_TRUE(mapping.ok());
  EXPECT_EQ(mapping->size(), kBytes);
  EXPECT_EQ(mapping->bytes().back(), std::byte{0});
  EXPECT_FALSE(mapping->writable());
}

TEST(Memfd, RefusesSizesThatCannotBe) {
  EXPECT_EQ(Memfd::create("test", 0).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(Memfd::create("test", SIZE_MAX).error().code, ErrorCode::kInvalidArgument);
}

TEST(Memfd, WhereSomethingHasRunOutTheRemedyIsNamed) {
  rlimit all{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &all), 0);
  const rlimit few{3, all.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  const auto none = Memfd::create("test", 4096);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &all), 0);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(toString(none.error()),
            "test: memfd_create: Too many open files (end clients, or raise LimitNOFILE= or ulimit -n)");
  EXPECT_EQ(systemError("x", "call", ENOSPC).remedy, "make room on the disk");
  EXPECT_EQ(systemError("x", "call", ENOSPC, "the caller's").remedy, "the caller's");
  EXPECT_EQ(systemError("x", "call", EINVAL).remedy, "");
  EXPECT_EQ(unlessRunOut(ENOSPC, "of rights"), "make room on the disk");
  EXPECT_EQ(unlessRunOut(EACCES, "of rights"), "of rights");
}

TEST(Memfd, TruncationIsRefusedBothWaysOnceTheSizeIsFixed) {
  const Memfd memfd = make();
  ASSERT_EQ(truncateTo(memfd, kBytes + kPage), 0);  // allowed before
  ASSERT_EQ(truncateTo(memfd, kBytes), 0);
  ASSERT_TRUE(memfd.seal(Seals::kFixedSize).ok());
  EXPECT_EQ(truncateTo(memfd, kBytes + kPage), EPERM);
  EXPECT_EQ(truncateTo(memfd, kPage), EPERM);
}

TEST(Memfd, FutureWriteStopsHolesAndNewWritersButNotTheOldMapping) {
  const Memfd memfd = make();
  ASSERT_TRUE(memfd.seal(Seals::kFixedSize).ok());
  auto writer = memfd.map(Memfd::Access::kWrite);
  ASSERT_TRUE(writer.ok());
  std::memset(writer->data(), 7, kBytes);
  // Size alone does not protect the content: both ways of punching a hole work.
  ASSERT_EQ(punchHole(memfd), 0);
  EXPECT_EQ(writer->data()[0], std::byte{0});
  ASSERT_EQ(madviseRemove(*writer), 0);
  ASSERT_TRUE(memfd.map(Memfd::Access::kWrite).ok());

  ASSERT_TRUE(memfd.seal(Seals::kNoNewWriters).ok());
  writer->data()[0] = std::byte{9};  // the old mapping goes on
  EXPECT_EQ(punchHole(memfd), EPERM);
  EXPECT_EQ(madviseRemove(*writer), EPERM);
  auto late = memfd.map(Memfd::Access::kWrite);
  ASSERT_FALSE(late.ok());
  EXPECT_EQ(late.error().code, ErrorCode::kSystem);
  auto reader = memfd.map(Memfd::Access::kRead);
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(reader->data()[0], std::byte{9});
  EXPECT_NE(::mprotect(reader->data(), kPage, PROT_READ | PROT_WRITE), 0);
}

TEST(Memfd, FreezingNeedsEverybodyUnmapped) {
  const Memfd memfd = make();
  ASSERT_TRUE(memfd.seal(Seals::kFixedSize).ok());
  {
    auto writer = memfd.map(Memfd::Access::kWrite);
    ASSERT_TRUE(writer.ok());
    writer->data()[5] = std::byte{42};
    EXPECT_EQ(memfd.seal(Seals::kFrozen).error().code, ErrorCode::kStillMapped);
    EXPECT_TRUE(memfd.requireSeals(Seals::kFixedSize).ok()) << "a refused freeze must change nothing";
  }
  ASSERT_TRUE(memfd.seal(Seals::kFrozen).ok());
  EXPECT_TRUE(memfd.seal(Seals::kFrozen).ok()) << "sealing again is no error";
  EXPECT_FALSE(memfd.map(Memfd::Access::kWrite).ok());
  auto copy = memfd.map(Memfd::Access::kPrivate);
  ASSERT_TRUE(copy.ok());
  copy->data()[5] = std::byte{1};
  auto reader = memfd.map(Memfd::Access::kRead);
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(reader->data()[5], std::byte{42});
}

TEST(Memfd, SealsAreExact) {
  const Memfd memfd = make();
  EXPECT_FALSE(memfd.requireSeals(Seals::kFixedSize).ok());
  ASSERT_TRUE(memfd.seal(Seals::kFixedSize).ok());
  EXPECT_TRUE(memfd.requireSeals(Seals::kFixedSize).ok());
  const auto missing = memfd.requireSeals(Seals::kNoNewWriters);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kPermissionDenied);
  EXPECT_EQ(missing.error().what, "its seals are SHRINK|GROW and must be SHRINK|GROW|FUTURE_WRITE|SEAL");
  ASSERT_EQ(::fcntl(memfd.fd(), F_ADD_SEALS, F_SEAL_FUTURE_WRITE), 0);
  EXPECT_FALSE(memfd.requireSeals(Seals::kFixedSize).ok()) << "one too many is as wrong as one too few";
  EXPECT_FALSE(memfd.requireSeals(Seals::kNoNewWriters).ok()) << "without SEAL somebody could add more";
  ASSERT_TRUE(memfd.seal(Seals::kNoNewWriters).ok());
  EXPECT_FALSE(memfd.seal(Seals::kFrozen).ok()) << "SEAL is final";
}

TEST(Memfd, AdoptTakesOnlySealableMemory) {
  const Memfd memfd = make();
  auto shared = memfd.share();
  ASSERT_TRUE(shared.ok());
  auto adopted = Memfd::adopt(std::move(*shared));
  ASSERT_TRUE(adopted.ok());
  EXPECT_EQ(adopted->size(), kBytes);
  EXPECT_EQ(Memfd::adopt(UniqueFd(::open("/dev/null", O_RDWR | O_CLOEXEC))).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(Memfd::adopt(UniqueFd(::memfd_create("plain", MFD_CLOEXEC))).error().code, ErrorCode::kInvalidArgument)
      << "empty";
  EXPECT_EQ(Memfd::adopt(UniqueFd()).error().code, ErrorCode::kInvalidArgument);
}

TEST(Mapping, LockingMakesEveryPagePresentAndKeepsTheContent) {
  const Memfd memfd = make();
  auto writer = memfd.map(Memfd::Access::kWrite);
  ASSERT_TRUE(writer.ok());
  std::memset(writer->data(), 3, kBytes);
  const auto locked = writer->lock();
  ASSERT_TRUE(locked.ok()) << toString(locked.error());
  EXPECT_EQ(writer->data()[kBytes - 1], std::byte{3});
  rusage before{}, after{};
  ::getrusage(RUSAGE_THREAD, &before);
  for (std::size_t i = 0; i < kBytes; i += kPage) writer->data()[i] = std::byte{4};
  ::getrusage(RUSAGE_THREAD, &after);
  EXPECT_EQ(after.ru_minflt, before.ru_minflt);
}

TEST(Mapping, MovesAndUnmaps) {
  const Memfd memfd = make();
  auto writer = memfd.map(Memfd::Access::kWrite);
  ASSERT_TRUE(writer.ok());
  Mapping moved = std::move(*writer);
  EXPECT_FALSE(static_cast<bool>(*writer));
  ASSERT_TRUE(static_cast<bool>(moved));
  moved = Mapping();
  EXPECT_TRUE(memfd.seal(Seals::kFrozen).ok()) << "the mapping is gone, so the freeze goes through";
}

TEST(UniqueFd, ClosesOnce) {
  UniqueFd a(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  const int raw = a.get();
  UniqueFd b = std::move(a);
  EXPECT_FALSE(a.valid());
  EXPECT_EQ(::fcntl(raw, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
  b.reset();
  EXPECT_EQ(::fcntl(raw, F_GETFD), -1);
}

}  // namespace
}  // namespace hapticd
