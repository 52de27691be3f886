// Damaged files of every format: refused, or read as an image that is one; whoever dies of them dies alone.
#include <pthread.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

#include "tests/support/seeds.h"
#include "tests/unit/import/dicom_file.h"
#include "tools/hapticctl-import/child.h"
#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/input.h"

namespace hapticctl_import::test {
namespace {

enum Outcome { kRead = 0, kRefused = 5, kNonsense = 6, kDied = 7 };

/** What comes of importing a path, in a child that may have 1 GB and 20 s. */
int outcomeOf(const std::string& path) {
  try {
    return inChild(
        [&]() -> int {
          const rlimit seconds{20, 20};
          ::setrlimit(RLIMIT_CPU, &seconds);
          try {
            InputOptions options;
            options.file = path;
            const Image image = readInput(options);
            if (image.values.size() != std::size_t{image.size[0]} * image.size[1] * image.size[2]) return kNonsense;
            for (const float v : image.values)
              if (!std::isfinite(v)) return kNonsense;
            checkPlace(image);
            return kRead;
          } catch (const ImportError& error) {
            return *error.what() == '\0' ? kNonsense : kRefused;
          } catch (const std::bad_alloc&) {
            return kRefused;
          }
        },
        std::uint64_t{1} << 30);
  } catch (const ImportError&) {
    return kDied;
  }
}

struct Format {
  const char* name;
  std::string bytes;
  std::size_t header;  ///< Bytes that are damaged one by one.
};

std::vector<Format> formats() {
  const std::string packed = compressed(samples());
  const std::string told = fmt::format("CompressedData = True\nCompressedDataSize = {}\n", packed.size());
  const std::string plain = nrrd("encoding: raw\nendian: little\nspacings: 1 1.5 2\n");
  return {{"a.mha", metaImage() + samples(), metaImage().size()},
          {"b.mha", metaImage(told) + packed, metaImage(told).size() + 64},
          {"c.nrrd", plain + samples(), plain.size()},
          {"d.nrrd", nrrd("encoding: gzip\nendian: little\n") + compressed(samples(), 31), 200},
          {"e.nii", nifti() + samples(), 352},
          {"f.nii.gz", compressed(nifti() + samples(), 31), 400}};
}

TEST(Damage, whatIsCutShortIsRefused) {
  const Folder folder;
  int died = 0;
  for (const Format& f : formats()) {
    ASSERT_EQ(outcomeOf(folder.put(f.name, f.bytes)), kRead) << f.name;
    for (std::size_t n = 0; n < f.bytes.size(); n += 1 + f.bytes.size() / 23) {
      const int outcome = outcomeOf(folder.put(f.name, f.bytes.substr(0, n)));
      EXPECT_TRUE(outcome == kRefused || outcome == kDied) << f.name << " at " << n << ": " << outcome;
      died += outcome == kDied;
    }
  }
  RecordProperty("died", died);
}

TEST(Damage, wrongBytesAreRefusedOrMakeAnImage) {
  const Folder folder;
  hapticd::Random random(hapticd::seedOf(7));
  int refused = 0, died = 0, read = 0;
  for (const Format& f : formats())
    for (std::size_t at = 0; at < f.header; at += 1 + f.header / 60) {
      std::string bytes = f.bytes;
      flip(bytes, at, random);
      const int outcome = outcomeOf(folder.put(f.name, bytes));
      EXPECT_NE(outcome, kNonsense) << f.name << " at " << at;
      refused += outcome == kRefused;
      died += outcome == kDied;
      read += outcome == kRead;
    }
  EXPECT_GT(refused, 30);
  RecordProperty("refused", refused);
  RecordProperty("died", died);
  RecordProperty("read", read);
}

/** The ball in slices of which one is damaged. */
int outcomeOfSeries(const std::function<void(std::string&)>& damage) {
  const Folder folder;
  for (std::size_t z = 0; z < 4; ++z) {
    std::string bytes = dicomFile(ballSlice(z));
    if (z == 1) damage(bytes);
    (void)folder.put(fmt::format("IM{}", z), bytes);
  }
  return outcomeOf(folder.path());
}

TEST(Damage, ofADicomSliceIsRefusedOrLeavesAnImage) {
  ASSERT_EQ(outcomeOfSeries([](std::string&) {}), kRead);
  const std::size_t size = dicomFile(ballSlice(1)).size();
  int refused = 0, died = 0;
  for (std::size_t n = 0; n + 2 < size; n += 1 + size / 23) {
    const int outcome = outcomeOfSeries([n](std::string& bytes) { bytes.resize(n); });
    EXPECT_TRUE(outcome == kRefused || outcome == kDied) << n << ": " << outcome;
    died += outcome == kDied;
  }
  hapticd::Random random(hapticd::seedOf(5));
  for (std::size_t at = 0; at < size - 960; at += 11) {
    const int outcome = outcomeOfSeries([&](std::string& bytes) { flip(bytes, at, random); });
    EXPECT_NE(outcome, kNonsense) << at;
    refused += outcome == kRefused;
    died += outcome == kDied;
  }
  EXPECT_GT(refused, 10);
  RecordProperty("died", died);
}

TEST(Damage, whoDiesOfAFileDiesAlone) {
  EXPECT_THAT(refusal([] {
                return inChild([]() -> int {
                  ::raise(SIGSEGV);
                  return 0;
                });
              }),
              ::testing::HasSubstr("Segmentation fault"));
  EXPECT_EQ(inChild([] { return 3; }), 3);
  EXPECT_EQ(inChild(
                [] {
                  try {
                    const std::vector<char> much(std::size_t{1} << 31);
                    const char* const volatile there = much.data();  // Else a compiler may leave it out.
                    return there == nullptr ? 1 : 0;
                  } catch (const std::bad_alloc&) {
                    return 9;
                  }
                },
                std::uint64_t{1} << 30),
            9);
}

// An import that was ended as it began left the surface of a child that nobody waited for any more.
TEST(Damage, aChildWhoseParentHasEndedSinceReadsNothing) {
  int open[2];
  ASSERT_EQ(::pipe(open), 0);
  const pid_t parent = ::fork();
  if (parent == 0) {
    ::pthread_atfork(nullptr, nullptr, [] {
      const pid_t mine = ::getppid();
      ::kill(mine, SIGKILL);
      while (::getppid() == mine) ::usleep(100);
    });
    (void)inChild([&] { return ::write(open[1], "read", 4) == 4 ? 0 : 1; });
    ::_exit(0);
  }
  ::close(open[1]);
  char said = 0;
  EXPECT_EQ(::read(open[0], &said, 1), 0) << "until its end";
  ::close(open[0]);
  ::waitpid(parent, nullptr, 0);
}

}  // namespace
}  // namespace hapticctl_import::test
