// What a .vdb of ours says of itself: whatever single bit of it is wrong, the file is refused or read as it was.
#include "tests/unit/import/ball.h"
#include "tools/hapticctl-import/child.h"
#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/format/vdb_file.h"
#include "tools/hapticctl-import/input.h"
#include "tools/hapticctl-import/isosurface.h"
#include "tools/hapticctl-import/model.h"

namespace hapticctl_import::test {
namespace {

enum Read { kAsItWas = 0, kReadRefused = 5, kOtherwise = 6, kReadDied = 7 };

/** Written by another process, whose memory would make each fork slow. */
std::string ours(const Folder& folder) {
  const std::string path = folder.path() + "/ours.vdb";
  EXPECT_EQ(inChild([&] {
              Image ball;
              ball.size = kSize;
              ball.step = kPlain;
              for (std::size_t i = 0; i < std::size_t{24} * 20 * 16; ++i)
                ball.values.push_back(valueAt(i % 24, i / 24 % 20, i / 480));
              (void)writeModel(isosurface(ball, 200), 2, path);
              return 0;
            }),
            0);
  return path;
}

bool same(const Image& a, const Image& b) {
  return a.size == b.size && a.values == b.values && a.origin == b.origin && a.step == b.step && a.format == b.format &&
         a.distances == b.distances && a.usual_iso == b.usual_iso;
}

TEST(VdbMetadata, noBitOfItIsTakenForAnother) {
  const Folder folder;
  InputOptions options;
  options.file = ours(folder);
  const Image truth = readInput(options);
  const std::vector<VdbGrid> grids = gridsOf(options.file);
  ASSERT_EQ(grids.size(), 1u) << "of floats";
  std::string bytes = readFile(options.file);
  // All that stands before the first tree's values, from magic to transform.
  const std::size_t end = bytes.find("UniformScaleTranslateMap");
  ASSERT_LT(end, 2000u);
  options.file = folder.path() + "/flipped.vdb";
  int count[8] = {};
  for (std::size_t at = 0; at < end + 160; at += 2) {
    const char was = bytes[at];
    bytes[at] = static_cast<char>(was ^ (1 << (at % 7)));
    (void)folder.put("flipped.vdb", bytes);
    bytes[at] = was;
    int outcome = kReadDied;
    try {
      outcome = inChild(
          [&]() -> int {
            try {
              return same(readInput(options), truth) ? kAsItWas : kOtherwise;
            } catch (const ImportError&) {
              return kReadRefused;
            } catch (const std::exception&) {
              return kReadRefused;
            }
          },
          std::uint64_t{1} << 28);  // Lengths are damaged too, and are allocated.
    } catch (const ImportError&) {
    }
    EXPECT_NE(outcome, kOtherwise) << "byte " << at << ", behind '" << bytes.substr(at < 24 ? 0 : at - 24, 24) << "'";
    ++count[outcome];
  }
  RecordProperty("as_it_was", count[kAsItWas]);
  EXPECT_GT(count[kReadRefused], 200);
}

}  // namespace
}  // namespace hapticctl_import::test
