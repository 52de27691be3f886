/** @file
 * The two streams of a probe: no force is lost when they are merged, and no column when they are read.
 */
#include "tools/haptic-bench/measured/recording.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/support/process/temporary_directory.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/measured/measured.h"
#include "tools/haptic-bench/measured/synthetic.h"
#include "tools/haptic-bench/model/shapes.h"
#include "tools/haptic-bench/trajectory/generators.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/** Five seconds and a turned probe that weighs nothing; the force along x of the world tells the time. */
Recording timesAsForces(double force_hz, double later) {
  Apparatus a;
  a.force_hz = force_hz;
  a.free_s = 0;
  Recording recording = record(lissajous(plane(0.05, 3), {5, 2000, 1}), a);
  for (PoseSample& p : recording.poses) p.t_s += later, p.X_OS.q.setIdentity();
  for (ForceSample& f : recording.forces) f.f_S = Vec3(f.t_s, 0, 0), f.t_s += later;
  return recording;
}

// At equal rates every force lay on the border of two windows: of 5000 some 3000 were used, in steps of 1, 2 and 3 ms.
TEST(MergedStreams, UseEveryForceOnce) {
  for (const double later : {0.0, 0.3, 1.7e9}) {
    for (const double hz : {500.0, 1000.0, 2000.0, 5000.0}) {
      const Recording recording = timesAsForces(hz, later);
      const std::vector<ProbeSample> merged = merge(recording, {});
      const double end = std::min(recording.forces.back().t_s, recording.poses.back().t_s) - later;
      const double step = std::max(1e-3, 1 / hz);
      ASSERT_EQ(merged.size(), static_cast<std::size_t>(end / step + 1e-3) + 1) << hz << " Hz, " << later;
      for (std::size_t i = 0; i < merged.size(); ++i) {
        ASSERT_NEAR(merged[i].t_s - later, step * static_cast<double>(i), 1e-6) << hz << " Hz, " << later;
        // The mean of all forces that are nearest to it is its own time, but for one that lies between two.
        const double off = i == 0 || i + 1 == merged.size() ? step / 2 : hz == 2000 ? 0.26e-3 : 1e-6;
        ASSERT_NEAR(merged[i].force_O.x(), step * static_cast<double>(i), off) << hz << " Hz, " << later;
      }
    }
  }
}

TEST(MergedStreams, AnObjectThatMovesNeedsItsWholePose) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string forces = directory.path() + "/f.csv", poses = directory.path() + "/p.csv";
  std::ofstream(forces) << "t,fx,fy,fz\n0,0,0,1\n1,0,0,1\n";
  const auto write = [&](const std::string& names) {
    std::ofstream(poses) << "t,x,y,z,qw,qx,qy,qz,object_x,object_y,object_z," << names
                         << "\n0,0,0,0,1,0,0,0,1,0,0,1,0,0,0\n1,0,0,0,1,0,0,0,1,0,0,1,0,0,0\n";
  };
  write("object_qw,object_qx,object_qy,object_qz");
  EXPECT_EQ(readRecording(forces, poses).poses[0].X_OS.p, Vec3(-1, 0, 0));
  // It was taken for one that stands still.
  for (const char* names : {"object_w,object_qx,object_qy,object_qz", "note_1,note_2,note_3,note_4"}) {
    write(names);
    EXPECT_THAT([&] { (void)readRecording(forces, poses); }, ThrowsMessage<Failure>(HasSubstr("no column object_qw")));
  }
}

TEST(MergedStreams, EverySettingOfARecordingIsHeeded) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string forces = directory.path() + "/f.csv", poses = directory.path() + "/p.csv";
  const Model model = plane(0.05, 3);
  const std::vector<SurfaceSample> out = lissajous(model, {2, 2000, 1});
  Apparatus a;
  a.free_s = 0;
  a.tip_S = Vec3(0.01, -0.02, 0.1);
  a.load.weight = 0.3;
  a.X_OM = {Vec3(0.1, 0.2, -0.05), Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vec3::UnitZ()))};
  const Recording recording = record(out, a);
  const auto writePoses = [&](double gap_from, double gap_to) {
    std::ofstream file(poses);
    file << "t,x,y,z,qw,qx,qy,qz\n";
    for (const PoseSample& s : recording.poses) {
      const Vec3& p = s.X_OS.p;
      const Eigen::Quaterniond& q = s.X_OS.q;
      if (s.t_s > gap_from && s.t_s < gap_to) continue;
      file << fmt::format("{},{},{},{},{},{},{},{}\n", s.t_s + 0.25, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
    }
  };
  {
    std::ofstream file(forces);
    file << "t,fx,fy,fz\n";
    for (const ForceSample& s : recording.forces)
      file << fmt::format("{},{},{},{}\n", s.t_s, s.f_S.x(), s.f_S.y(), s.f_S.z());
  }
  const Vec3 at = a.X_OM.inverse().p;
  const auto read = [&](const std::string& more, double above = 0) {
    Spec spec(
        fmt::format("measured:forces={},poses={},tip_x=0.01,tip_y=-0.02,tip_z=0.1,tip_radius={},"
                    "weight=0.3,rate=500,clock=-0.25,x={},y={},z={},turn_z=-0.3{}",
                    forces, poses, a.tip_radius, at.x(), at.y(), at.z() + above, more));
    return readMeasured(spec, model);
  };
  writePoses(0, 0);
  const std::vector<SurfaceSample> got = read(",registered=1");
  ASSERT_NEAR(static_cast<double>(got.size()), 2 * 500, 12) << "but for what lies beyond the last pose";
  for (std::size_t i = 0; i < got.size(); ++i) {
    ASSERT_NEAR(got[i].t_s, 0.002 * static_cast<double>(i), 1e-9);
    ASSERT_NEAR(got[i].force, 1, 2e-3) << i;
    ASSERT_LT((got[i].point - out[std::min(4 * i, out.size() - 1)].point).norm(), 3e-4) << i;
  }
  EXPECT_NEAR(read(",registered=1", 0.002)[300].point.z(), 0.002, 1e-4) << "as the guess has it";
  EXPECT_NEAR(read("", 0.002)[300].point.z(), 0, 1e-4) << "as the mesh has it";
  EXPECT_THAT([&] { (void)read(",registered=1,contact=1.1"); },
              ThrowsMessage<Failure>(HasSubstr("nothing is touched")));
  writePoses(0.5, 1);
  EXPECT_THAT([&] { (void)read(",registered=1"); }, ThrowsMessage<Failure>(HasSubstr(poses)));
  EXPECT_NO_THROW((void)read(",registered=1,max_gap=0.6"));
}

}  // namespace
}  // namespace haptic_bench
