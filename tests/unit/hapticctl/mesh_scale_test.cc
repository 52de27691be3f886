// The unit of a mesh file: what it would make of the mesh, what it may be.
#include "tools/hapticctl/file/mesh_scale.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

MeshFile box() {
  MeshFile mesh;
  mesh.path = "t.stl";
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 5}};
  measure(mesh);
  return mesh;
}

TEST(MeshScale, AsksForAScale) {
  const MeshFile mesh = box();
  const std::string advice = scaleAdvice(mesh);
  EXPECT_THAT(advice, HasSubstr("its box is 2 x 3 x 5 file units"));
  EXPECT_THAT(advice, HasSubstr("--scale mm      would make it 2.00 mm x 3.00 mm x 5.00 mm"));
  EXPECT_THAT(advice, HasSubstr("--scale inch    would make it 50.8 mm x 76.2 mm x 127 mm"));
}

TEST(MeshScale, ScalesAndCentres) {
  MeshFile mesh = box();
  centre(mesh);
  scale(mesh, parseScale("cm"));
  EXPECT_NEAR(mesh.lower[2], -0.025, 1e-9);
  EXPECT_NEAR(mesh.upper[0], 0.01, 1e-9);
  for (const double wrong : {1e-60, 1e-30, 1e-5, 1e6}) {
    MeshFile other = mesh;
    try {
      scale(other, wrong);
      ADD_FAILURE() << wrong;
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.where, "--scale");
      EXPECT_THAT(failure.what, HasSubstr("from 1e-06 to 200 m"));
      EXPECT_THAT(failure.remedy, HasSubstr("its box is 0.02 x 0.03 x 0.05 file units"));
    }
  }
}

TEST(MeshScale, TellsOfASizeThatIsHardlyMeant) {
  for (const auto& [scaled, told] :
       {std::pair{1.0, "5.00 m; if that is not meant, name the file's unit, as --scale mm"},
        std::pair{1e-5, "50.0 um; if that is not meant, name the file's unit, as --scale m"}}) {
    MeshFile mesh = box();
    scale(mesh, scaled);
    EXPECT_THAT(sizeNote(mesh), HasSubstr(told));
  }
  for (const double usual : {0.0002, 0.001, 0.3}) {
    MeshFile mesh = box();
    scale(mesh, usual);
    EXPECT_EQ(sizeNote(mesh), "") << usual;
  }
}

TEST(MeshScale, NamesTheOptionThatWasGiven) {
  MeshFile mesh = box();
  try {
    scale(mesh, 1e-30, "--size");
    ADD_FAILURE() << "too small";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.where, "--size");
  }
}

TEST(MeshScale, SaysOfWhichFormatsTheUnitIsKnown) {
  MeshFile mesh = box();
  EXPECT_THAT(scaleAdvice(mesh), Not(HasSubstr("metres:")));
  mesh.path = "t.dae";
  EXPECT_THAT(scaleAdvice(mesh), HasSubstr("COLLADA is read in metres, whatever unit it names: --scale m"));
  EXPECT_EQ(whyScale(mesh), "its format is read in metres");
  mesh.path = "T.GLB";
  EXPECT_THAT(scaleAdvice(mesh), HasSubstr("glTF is in metres by its standard: --scale m"));
  mesh.path = "t.X3D";
  EXPECT_THAT(scaleAdvice(mesh), HasSubstr("X3D is read in metres"));
  mesh.path = "t.fbx";
  EXPECT_EQ(whyScale(mesh), "the unit that the file names is not read");
  EXPECT_THAT(scaleAdvice(mesh), HasSubstr("--scale cm"));
  mesh.path = "t.obj";
  EXPECT_EQ(whyScale(mesh), "the file does not say its unit");
}

TEST(MeshScale, IsAUnitOrAPositiveNumber) {
  EXPECT_EQ(parseScale("mm"), 1e-3);
  EXPECT_EQ(parseScale("in"), 0.0254);
  EXPECT_EQ(parseScale("0.0005"), 0.0005);
  for (const char* bad : {"0", "-1", "nan", "inf", "yard", ""}) EXPECT_THROW((void)parseScale(bad), Failure) << bad;
}

}  // namespace
}  // namespace hapticctl
