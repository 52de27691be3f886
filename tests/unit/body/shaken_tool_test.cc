// What a tool is shaken by where it slides over corners, edges and rims: each answer of the collide thread tells of a
// plane, and as long as that stands still what turns in the truth turns by leaps.
#include <gtest/gtest.h>

#include "tests/support/random.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::kBlock;
using test::kBrick;
using test::kSpoke;
using test::kStylus;
using test::kTin;
using test::kTub;

struct Slide {
  const char* name;
  Shape tool, ground;
  Vec3 first_turn;
  double most;    ///< Of all changes of the contact's force under three hands [N].
  int parts = 0;  ///< Of a ground that is a mesh, along an edge of each of its 12 triangles; 0: it is none.
  int tool_parts = 0;
};

void PrintTo(const Slide& slide, std::ostream* out) { *out << slide.name; }

class ShakenTool : public ::testing::TestWithParam<Slide> {};

/** Half as much as where planes stood still, or points of its faces were caught by edges beside them. */
TEST_P(ShakenTool, SlidesOverEdges) {
  const Slide& slide = GetParam();
  double shaken = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    shaken += test::wander({slide.tool, slide.ground, slide.tool_parts, slide.parts, slide.first_turn}, random).shaken;
  }
  EXPECT_LT(shaken, slide.most);
}

const Shape kMarble{ShapeKind::kSphere, {0.01, 0, 0}};
const Vec3 kUpright(0, 0, 0), kFlat(1.57, 0, 0);

INSTANTIATE_TEST_SUITE_P(Of, ShakenTool,
                         ::testing::Values(Slide{"ABallOnABlock", kMarble, kBlock, kUpright, 600},
                                           Slide{"ABallOnATin", kMarble, kTin, kUpright, 600},
                                           Slide{"ABallOnAMesh", kMarble, kBlock, kUpright, 600, 1},
                                           Slide{"ABallOnAFineMesh", kMarble, kBlock, kUpright, 600, 12},
                                           Slide{"ABrickOnABlock", kBrick, kBlock, kUpright, 2000},
                                           Slide{"ABrickOfAMeshOnABlock", kBrick, kBlock, kUpright, 2000, 0, 6},
                                           Slide{"ATubOnABlock", kTub, kBlock, kUpright, 1600},
                                           Slide{"ATubOnATin", kTub, kTin, kUpright, 2100},
                                           Slide{"ASpokeOnABlock", kSpoke, kBlock, kFlat, 500},
                                           Slide{"ASpokeOnATin", kSpoke, kTin, kFlat, 850},
                                           Slide{"AStylusOnABlock", kStylus, kBlock, kFlat, 850},
                                           Slide{"AStylusOnATin", kStylus, kTin, kFlat, 500}),
                         [](const auto& slide) { return slide.param.name; });

}  // namespace
}  // namespace hapticd
