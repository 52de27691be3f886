// The pantograph: bytes against the published layout, kinematics against differences, and what goes wrong on a serial
// line.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <bit>
#include <cmath>

#include "drivers/link/io_device.h"
#include "drivers/pantograph/pantograph_io.h"
#include "drivers/serial/tty_transport.h"
#include "tests/support/stepped/push.h"
#include "tests/support/time.h"
#include "tools/haptic-emu/pantograph/pantograph_model.h"

namespace hapticd::test {
namespace {

using pantograph::Vec2;

struct Bench {
  Bench() {
    auto resolved = resolvePantograph({"pantograph", "/dev/played", {}});
    EXPECT_TRUE(resolved.ok());
    resolved->line = [this] { return std::make_unique<haptic_emu::InProcessSerial>(model, clock); };
    device = std::make_unique<IoDevice>(std::make_unique<PantographIo>(std::move(*resolved)),
                                        IoOptions{.thread = false}, clock);
    opened = device->open();
  }
  int run(int cycles, const DeviceCommand& command) {
    int fresh = 0;
    for (int i = 0; i < cycles; ++i) {
      if (held) model.hand.place(at);
      device->read(clock.now(), sample);
      fresh += sample.fresh ? 1 : 0;
      device->write(clock.now(), command);
      device->pump(clock.now() + kMs);
      model.advance(clock.now());
    }
    return fresh;
  }
  /** A hand brings the grip there. */
  void hold(const Vec3& p) {
    const Vec3 from = model.hand.position();
    held = true;
    for (int i = 1; i <= 50; ++i) {
      at = from + (p - from) * (i / 50.0);
      run(1, {});
    }
  }
  void trouble(haptic_emu::FaultKind kind) { model.faults.add({kind, 0, INT64_MAX}); }

  haptic_emu::PantographModel model;
  ManualClock clock;
  std::unique_ptr<IoDevice> device;
  Result<void> opened;
  DeviceSample sample;
  bool held = false;
  Vec3 at = Vec3::Zero();
};

const std::vector<Vec3> kPlaces = {Vec3(0, 0, 0), Vec3(0.02, 0.02, 0), Vec3(-0.02, 0.015, 0), Vec3(0.01, -0.025, 0)};

TEST(PantographSetup, ItsWorkspaceStaysWhereTheBarsReachWhereverZeroIs) {
  for (const char* const centre : {"0.04", "0.07", "0.11"}) {
    const auto setup = resolvePantograph({"pantograph", "/dev/played", {{"centre", centre}}});
    ASSERT_TRUE(setup.ok());
    const DeviceInfo& info = setup->info;
    const double from_motors = setup->parameters.centre;
    EXPECT_NEAR(from_motors + info.workspace_lower.x(), 0.045, 1e-12) << centre;
    EXPECT_NEAR(from_motors + info.workspace_upper.x(), 0.095, 1e-12) << centre;
    EXPECT_NEAR(from_motors + info.max_workspace_lower.x(), 0.02, 1e-12) << centre;
    EXPECT_NEAR(from_motors + info.max_workspace_upper.x(), 0.115, 1e-12) << centre;
  }
}

TEST(Pantograph, SpeaksAsThePublishedLayout) {
  EXPECT_EQ(pantograph::encodeReset(), (std::array<std::uint8_t, 2>{0, 5}));
  const auto setup = pantograph::encodeSetup({{{180, 13824, false}, {0, 13824, false}}}, false);
  const std::array<std::uint8_t, 26> wanted = {1, 5, 3,    0,    0, 3, 0,    0,    0, 0,  //
                                               0, 0, 0x34, 0x43, 0, 0, 0x58, 0x46,        // 180, 13824
                                               0, 0, 0,    0,    0, 0, 0x58, 0x46};
  EXPECT_EQ(setup, wanted);
  EXPECT_EQ(pantograph::encodeTorques({1.0f, std::nanf("")}),
            (std::array<std::uint8_t, 10>{2, 5, 0, 0, 0x80, 0x3f, 0, 0, 0, 0}));
  const auto turned = pantograph::encodeSetup({{{-90, 1000, false}, {45, 2000, true}}}, true);
  const std::array<std::uint8_t, 26> other = {1, 5, 3,    1,    1, 3, 0,    1,    0, 0,  //
                                              0, 0, 0xb4, 0xc2, 0, 0, 0x7a, 0x44,        // -90, 1000
                                              0, 0, 0x34, 0x42, 0, 0, 0xfa, 0x44};       // 45, 2000
  EXPECT_EQ(turned, other);
  EXPECT_EQ(pantograph::encodeTorques({0.1f, -0.2f}),
            (std::array<std::uint8_t, 10>{2, 5, 0xcd, 0xcc, 0xcc, 0x3d, 0xcd, 0xcc, 0x4c, 0xbe}));
}

TEST(Pantograph, FindsItsFootingByteByByte) {
  pantograph::Parser parser;
  const std::vector<std::uint8_t> answer = {5, 0, 0, 0x34, 0x43, 0, 0, 0xb4, 0xc2};  // 180, -90
  parser.feed(std::vector<std::uint8_t>{0x80, 0x99});
  for (const std::uint8_t byte : answer) {
    EXPECT_FALSE(parser.next());
    parser.feed({&byte, 1});
  }
  const auto angles = parser.next();
  ASSERT_TRUE(angles);
  EXPECT_EQ((*angles)[0], 180);
  EXPECT_EQ((*angles)[1], -90);
  EXPECT_EQ(parser.dropped(), 2u);
}

/** An answer of the board's. */
std::vector<std::uint8_t> answerOf(float first, float second) {
  std::vector<std::uint8_t> bytes{5};
  for (const float angle : {first, second}) {
    const auto bits = std::bit_cast<std::uint32_t>(angle);
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
  return bytes;
}

TEST(Pantograph, BelievesTwoTurnsAndNoMore) {
  for (const float angle : {720.0f, -720.0f, 0.0f}) {
    pantograph::Parser parser;
    parser.feed(answerOf(angle, -angle));
    const auto angles = parser.next();
    ASSERT_TRUE(angles) << angle;
    EXPECT_EQ((*angles)[1], -angle);
    EXPECT_EQ(parser.dropped(), 0u);
  }
  for (const float angle : {720.1f, -720.1f, std::nanf(""), HUGE_VALF}) {
    for (const bool second : {false, true}) {
      pantograph::Parser parser;
      parser.feed(second ? answerOf(0, angle) : answerOf(angle, 0));
      EXPECT_FALSE(parser.next()) << angle;
      EXPECT_EQ(parser.dropped(), 1u) << angle;
    }
  }
}

TEST(Pantograph, OfMoreThanThereIsRoomForTheNewestIsKept) {
  // Room for 256 bytes. At once, and on top of what waits.
  for (const std::size_t waiting : {0u, 5u, 250u, 256u}) {
    for (const std::size_t coming : {9u, 100u, 255u, 256u, 257u, 300u}) {
      pantograph::Parser parser;
      parser.feed(std::vector<std::uint8_t>(waiting, 0x77));
      std::vector<std::uint8_t> bytes(coming - 9, 0x77);
      for (const std::uint8_t byte : answerOf(12.3f, -34)) bytes.push_back(byte);
      parser.feed(bytes);
      const auto angles = parser.next();
      ASSERT_TRUE(angles) << waiting << " " << coming;
      EXPECT_EQ((*angles)[0], 12.3f);
      EXPECT_EQ((*angles)[1], -34);
      EXPECT_EQ(parser.dropped(), waiting + coming - 9) << "each byte is counted once";
      EXPECT_FALSE(parser.next());
    }
  }
}

TEST(Pantograph, TheGripIsAsFarFromBothElbowsOnTheOperatorsSide) {
  const pantograph::Bars bars;
  int seen = 0;
  for (double t1 = -3; t1 < 3; t1 += 0.2) {
    for (double t2 = -3; t2 < 3; t2 += 0.2) {
      const Vec2 a = bars.l * Vec2(std::cos(t1), std::sin(t1));
      const Vec2 b = Vec2(bars.d, 0) + bars.l * Vec2(std::cos(t2), std::sin(t2));
      const auto grip = pantograph::gripAt(bars, Vec2(t1, t2));
      ASSERT_EQ(grip.reachable, (b - a).norm() / 2 > 1e-4 && (b - a).norm() / 2 < 0.995 * bars.L) << t1 << " " << t2;
      if (!grip.reachable) continue;
      ++seen;
      ASSERT_NEAR((grip.p - a).norm(), bars.L, 1e-12);
      ASSERT_NEAR((grip.p - b).norm(), bars.L, 1e-12);
      ASSERT_GE(grip.p.y(), (a.y() + b.y()) / 2);
    }
  }
  EXPECT_GT(seen, 500);
  pantograph::Bars wide;
  wide.d = 0.06;
  const double straight = 0.995 * wide.L;
  for (const auto& [half, reachable] : {std::pair{0.0, false},
                                        {0.99e-4, false},
                                        {1.01e-4, true},
                                        {0.03, true},
                                        {straight - 1e-9, true},
                                        {straight + 1e-9, false},
                                        {wide.L - 1e-9, false}}) {
    const double t = std::acos((wide.d / 2 - half) / wide.l);  // Both elbows as high.
    EXPECT_EQ(pantograph::gripAt(wide, Vec2(t, EIGEN_PI - t)).reachable, reachable) << half;
  }
  EXPECT_FALSE(pantograph::gripAt(bars, Vec2(std::nan(""), 0)).reachable);
  EXPECT_FALSE(pantograph::gripAt(bars, Vec2(0, HUGE_VAL)).reachable);
}

TEST(Pantograph, JacobianIsTheDerivativeOfThePlace) {
  constexpr double kStep = 1e-7;
  int seen = 0;
  for (double t1 = 1.6; t1 < 3.4; t1 += 0.15) {
    for (double t2 = -0.3; t2 < 1.5; t2 += 0.15) {
      const auto grip = pantograph::gripAt({}, Vec2(t1, t2));
      if (!grip.reachable) continue;
      ++seen;
      for (int i = 0; i < 2; ++i) {
        const Vec2 step = kStep * Vec2::Unit(i);
        const Vec2 slope =
            (pantograph::gripAt({}, Vec2(t1, t2) + step).p - pantograph::gripAt({}, Vec2(t1, t2) - step).p) /
            (2 * kStep);
        // Near a straight line of the long bars the slope itself bends quickly.
        ASSERT_NEAR((slope - grip.jacobian.col(i)).norm(), 0, 1e-6 * (1 + std::pow(grip.jacobian.norm() / 0.05, 3)))
            << t1 << " " << t2;
      }
    }
  }
  EXPECT_GT(seen, 50);
  // Both elbows in one place: the grip could be anywhere about it.
  EXPECT_FALSE(pantograph::gripAt({}, Vec2(std::acos(0.2), std::acos(-0.2))).reachable);
}

TEST(Pantograph, ReadsWhereTheGripIs) {
  Bench bench;
  ASSERT_TRUE(bench.opened.ok()) << toString(bench.opened.error());
  for (const Vec3& p : kPlaces) {
    bench.hold(p);
    EXPECT_GT(bench.run(100, {}), 95);
    EXPECT_LT((bench.sample.p - p).norm(), 60e-6) << p.transpose();
  }
}

TEST(Pantograph, TheForceIsTheOneCommandedAndSaturatesInItsDirection) {
  Bench bench;
  for (const Vec3& p : kPlaces) {
    bench.hold(p);
    for (const Vec3& force : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-0.5, 0.8, 0)}) {
      bench.run(10, push(force));
      EXPECT_LT((bench.model.force() - force).norm(), 0.005) << p.transpose();
      for (const double large : {100.0, 1e300}) {
        bench.run(10, push(large * force));
        EXPECT_NEAR(bench.model.force().norm(), 2, 0.01);
        EXPECT_GT(bench.model.force().normalized().dot(force.normalized()), 0.9999);
        EXPECT_NE(bench.sample.status & kDeviceSaturated, 0u);
      }
    }
  }
  bench.run(10, push(Vec3(0, std::nan(""), 0)));
  EXPECT_TRUE(bench.model.force().isZero(0));
}

TEST(Pantograph, ZeroOnEveryWayOut) {
  for (int way = 0; way < 4; ++way) {
    Bench bench;
    bench.hold(Vec3::Zero());
    bench.run(20, push(Vec3(1, 1, 0)));
    ASSERT_GT(bench.model.force().norm(), 1.3);
    if (way == 0) bench.run(3, {});
    if (way == 1) bench.device->safe();
    if (way == 2) bench.device->close();
    if (way == 3) {  // a servo that is silent
      bench.device->pump(bench.clock.now() + 15 * kMs);
    }
    EXPECT_EQ(bench.model.torques()[0], 0) << way;
    EXPECT_EQ(bench.model.torques()[1], 0) << way;
  }
}

TEST(Pantograph, NoReadingIsWrongWhateverHappensOnTheLine) {
  using haptic_emu::FaultKind;
  for (const FaultKind kind : {FaultKind::kGarbage, FaultKind::kTruncation, FaultKind::kEncoderJump}) {
    Bench bench;
    bench.hold(Vec3(0.01, 0.01, 0));
    bench.run(20, {});
    bench.trouble(kind);
    double worst = 0;
    for (int i = 0; i < 1000; ++i) {
      if (bench.run(1, push(Vec3(0.5, 0, 0))) == 1)
        worst = std::max(worst, (bench.sample.p - Vec3(0.01, 0.01, 0)).norm());
    }
    EXPECT_LT(worst, 60e-6) << static_cast<int>(kind);
    const LinkCounters& counters = bench.device->link().counters;
    EXPECT_GT(counters.dropped_bytes.load() + counters.rejected.load() + counters.lost.load(), 15u);
    if (kind == FaultKind::kEncoderJump) {
      EXPECT_EQ(bench.device->calibration(), Calibration::kNeeded);
      EXPECT_TRUE(bench.model.force().isZero(0));
    }
  }
}

TEST(PantographIo, AHandThatMovesWhileNothingIsHeardIsBelieved) {
  Bench bench;
  ASSERT_TRUE(bench.opened.ok());
  bench.hold(Vec3(-0.02, -0.03, 0));
  bench.trouble(haptic_emu::FaultKind::kSilence);
  bench.hold(Vec3(0.02, 0.03, 0));
  bench.model.faults.clear();
  EXPECT_GT(bench.run(50, {}), 30);
  EXPECT_EQ(bench.device->calibration(), Calibration::kDone);
  EXPECT_LT((bench.sample.p - Vec3(0.02, 0.03, 0)).norm(), 1e-4);
}

TEST(Pantograph, ABoardThatIsNoneAndALineThatIsPulled) {
  Bench bench;
  bench.hold(Vec3::Zero());
  bench.run(20, push(Vec3(1, 0, 0)));
  bench.trouble(haptic_emu::FaultKind::kUnplug);
  bench.run(5, {});
  EXPECT_EQ(bench.sample.status, kDeviceGone);
  bench.model.faults.clear();
  bench.trouble(haptic_emu::FaultKind::kSilence);
  bench.device->close();
  const auto opened = bench.device->open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kTimeout);
  EXPECT_FALSE(resolvePantograph({"pantograph", "", {}}).ok());
}

TEST(PantographIo, ABoardThatFellSilentCountsFromWhereverItsArmsAre) {
  Bench bench;
  bench.hold(Vec3(0.01, 0.02, 0));
  bench.run(20, push(Vec3(1, 0, 0)));
  bench.trouble(haptic_emu::FaultKind::kSilence);
  bench.run(1100, {});
  EXPECT_EQ(bench.sample.status, kDeviceGone);
  bench.model.faults.clear();
  EXPECT_EQ(bench.run(1000, push(Vec3(1, 0, 0))), 0) << "it was set up anew, with its arms anywhere";
  EXPECT_EQ(bench.device->calibration(), Calibration::kNeeded);
  EXPECT_TRUE(bench.model.force().isZero(0));
  // Whoever unplugs it knows how to hold its arms.
  bench.trouble(haptic_emu::FaultKind::kUnplug);
  bench.run(1000, {});
  bench.model.faults.clear();
  EXPECT_GT(bench.run(1000, {}), 400);
  EXPECT_EQ(bench.device->calibration(), Calibration::kDone);
}

TEST(PantographIo, NorIsOneBelievedThatTookNothingForAWhile) {
  for (const bool pulled : {false, true}) {
    Bench bench;
    bench.hold(Vec3(0.01, 0.02, 0));
    bench.run(20, push(Vec3(1, 0, 0)));
    bench.model.deaf = !pulled;
    if (pulled) bench.trouble(haptic_emu::FaultKind::kUnplug);
    bench.run(100, {});
    EXPECT_EQ(bench.sample.status, kDeviceGone);
    bench.hold(Vec3(-0.01, 0, 0));
    // Its line was never seen to be away: whether its plug has a bad contact or it hung.
    bench.model.deaf = false;
    bench.model.faults.clear();
    EXPECT_EQ(bench.run(2000, push(Vec3(1, 0, 0))), 0) << pulled;
    EXPECT_EQ(bench.device->calibration(), Calibration::kNeeded);
    EXPECT_TRUE(bench.model.force().isZero(0));
    bench.trouble(haptic_emu::FaultKind::kUnplug);
    bench.run(1000, {});
    bench.model.faults.clear();
    EXPECT_GT(bench.run(1000, {}), 400) << pulled;
    EXPECT_EQ(bench.device->calibration(), Calibration::kDone);
  }
}

TEST(PantographIo, ArmsAreHeldWhileItBootsAndNotForEver) {
  for (const int seconds : {8, 12}) {
    Bench bench;
    bench.hold(Vec3(0.01, 0.02, 0));
    bench.trouble(haptic_emu::FaultKind::kUnplug);
    bench.run(1000, {});
    bench.model.faults.clear();
    bench.model.deaf = true;
    bench.run(1000 * seconds, {});
    bench.model.deaf = false;
    const bool held = seconds < 10;
    EXPECT_EQ(bench.run(1000, {}) > 400, held) << seconds;
    EXPECT_EQ(bench.device->calibration(), held ? Calibration::kDone : Calibration::kNeeded);
  }
}

TEST(PantographIo, OneThatNeverAnsweredIsHeldAnewWhenItIsPluggedInAgain) {
  Bench bench;
  bench.hold(Vec3(0.01, 0.02, 0));
  bench.trouble(haptic_emu::FaultKind::kUnplug);
  bench.run(1000, {});
  for (int i = 0; i < 2; ++i) {
    bench.model.faults.clear();
    bench.model.deaf = true;
    bench.run(8000, {});
    if (i != 0) break;
    bench.trouble(haptic_emu::FaultKind::kUnplug);
    bench.run(1000, {});
  }
  bench.model.deaf = false;
  EXPECT_GT(bench.run(1000, {}), 400) << "eight seconds after the plug";
  EXPECT_EQ(bench.device->calibration(), Calibration::kDone);
}

// The kernel's own line discipline: a pair of pseudo terminals.
TEST(TtyTransport, PassesEveryByteAndLocksTheLine) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(master, 0);
  ASSERT_EQ(::grantpt(master), 0);
  ASSERT_EQ(::unlockpt(master), 0);
  const std::string path = ::ptsname(master);
  TtyTransport line(path);
  const auto opened = line.open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  std::vector<std::uint8_t> all(256);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
  ASSERT_TRUE(line.write(all));
  std::vector<std::uint8_t> there(512);
  ASSERT_EQ(::read(master, there.data(), there.size()), 256);
  EXPECT_TRUE(std::equal(all.begin(), all.end(), there.begin()));  // no carriage returns, no signals
  ASSERT_EQ(::write(master, all.data(), all.size()), 256);
  std::vector<std::uint8_t> back;
  for (int i = 0; i < 10 && back.size() < 256; ++i) {
    std::size_t size = 0;
    ASSERT_TRUE(line.read(there, size, line.now() + 1000 * kMs));
    back.insert(back.end(), there.begin(), there.begin() + static_cast<std::ptrdiff_t>(size));
  }
  EXPECT_EQ(back, all);
  std::size_t size = 7;
  EXPECT_TRUE(line.read(there, size, 0));
  EXPECT_EQ(size, 0u);

  TtyTransport other(path);
  const auto second = other.open();
  ASSERT_FALSE(second.ok());
  // Root passes TIOCEXCL, not the lock.
  EXPECT_EQ(second.error().code, ErrorCode::kDeviceBusy);
  ::close(master);
  EXPECT_FALSE(line.read(there, size, line.now() + 1000 * kMs));  // hung up
  TtyTransport none("/dev/no-such-line");
  EXPECT_EQ(none.open().error().code, ErrorCode::kNotFound);
}

TEST(PantographIo, GivesItsLineBackWhenItIsClosed) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_TRUE(master >= 0 && ::grantpt(master) == 0 && ::unlockpt(master) == 0);
  const std::string path = ::ptsname(master);
  auto setup = resolvePantograph({"pantograph", path, {}});
  ASSERT_TRUE(setup.ok());
  PantographIo io(std::move(*setup));
  EXPECT_FALSE(io.open(std::atomic<bool>{true}).ok()) << "nobody waits for its answer";
  TtyTransport other(path);
  EXPECT_EQ(other.open().error().code, ErrorCode::kDeviceBusy);
  io.close();
  EXPECT_TRUE(other.open().ok());
  ::close(master);
}

}  // namespace
}  // namespace hapticd::test
