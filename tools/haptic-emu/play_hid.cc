#include "tools/haptic-emu/play_hid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "rt/base/clock.h"
#include "tools/haptic-emu/hidpid/pid_model.h"
#include "tools/haptic-emu/spacemouse/spacemouse_model.h"
#include "tools/haptic-emu/uhid.h"
#include "tools/haptic-emu/woodyhid/woody_hid_model.h"

namespace haptic_emu {
namespace {

using hapticd::Result;

/** To and fro between 0 and 1. */
double swing(std::int64_t t_ns, double period_s) {
  return 0.5 * (1 - std::cos(6.283185307179586 * static_cast<double>(t_ns) * 1e-9 / period_s));
}

/** A line now and then; what the hand felt most is told and forgotten. */
class Teller {
 public:
  explicit Teller(double every_s) : every_ns_(static_cast<std::int64_t>(every_s * 1e9)) {}

  void tell(std::int64_t t_ns, const Vec3& p, const Vec3& f, std::string_view more) {
    most_ = std::max(most_, f.norm());
    if (every_ns_ <= 0 || t_ns < next_ns_) return;
    next_ns_ = t_ns + every_ns_;
    fmt::print(
        "{{\"t_s\": {:.3f}, \"position_m\": [{:.5f}, {:.5f}, {:.5f}], \"force_n\": [{:.4f}, {:.4f}, {:.4f}], "
        "\"most_n\": {:.4f}, {}}}\n",
        static_cast<double>(t_ns) * 1e-9, p.x(), p.y(), p.z(), f.x(), f.y(), f.z(), std::exchange(most_, 0), more);
    std::fflush(stdout);
  }

 private:
  std::int64_t every_ns_, next_ns_ = 0;
  double most_ = 0;
};

Result<void> addFaults(const HidPlay& play, HidModel& model, std::int64_t start_ns) {
  for (const std::string& text : play.faults) {
    auto fault = parseFault(text);
    if (!fault) return fault.error();
    fault->from_ns += start_ns;
    fault->to_ns = fault->to_ns > INT64_MAX - start_ns ? INT64_MAX : fault->to_ns + start_ns;
    model.faults.add(*fault);
  }
  return {};
}

/** Puts the arm into its pose of calibration, presses the button a second after it is spoken to, then moves it. */
Result<void> playWoody(const HidPlay& play, const std::atomic<bool>& stop, std::int64_t start_ns) {
  const bool polhem = play.kind == "polhem3";
  WoodyHidModel model(polhem ? WoodyKind::kPolhem3 : WoodyKind::kWooden2015);
  if (auto added = addFaults(play, model, start_ns); !added) return added;
  // Polhem: where bodies A, B, C stand at 120, 125 and 239 degrees; WoodenHaptics: B upright, C level.
  const Vec3 calibration = polhem ? Vec3(-0.22259, 0.03081, 0.03701) : Vec3(0.025, 0, 0.205);
  Teller teller(play.every_s);
  std::int64_t spoken_ns = -1;
  bool pressed = false;
  model.hand.place(calibration);
  return playToUhid(model, {"Teensyduino RawHID", play.serial, 0x16c0, 0x0486}, stop, [&](std::int64_t now_ns) {
    if (!model.plugged()) {
      spoken_ns = -1;
      pressed = false;
    }
    if (spoken_ns < 0 && model.heard() > 0) spoken_ns = now_ns;
    if (spoken_ns >= 0 && !pressed && now_ns - spoken_ns > 1'000'000'000) {
      model.pressCalibration();
      pressed = true;
    }
    const bool ready = pressed && !model.pressed();
    model.hand.want(ready ? Vec3(-play.press * swing(now_ns, play.period_s), 0, 0) : calibration);
    teller.tell(now_ns - start_ns, model.hand.position(), model.force(),
                fmt::format("\"calibrated\": {}, \"amplifiers\": {}, \"reports\": {}", ready, model.amplifiersOn(),
                            model.heard()));
  });
}

/** Pushes the cap to the right and back; holds button 1 but for every fifth second. */
Result<void> playSpaceMouse(const HidPlay& play, const std::atomic<bool>& stop, std::int64_t start_ns) {
  const bool is_new = play.kind == "new";
  SpaceMouseModel model(is_new);
  if (auto added = addFaults(play, model, start_ns); !added) return added;
  Teller teller(play.every_s);
  bool held = false;
  const HidIdentity identity = is_new ? HidIdentity{"SpaceMouse Pro Wireless", play.serial, 0x256f, 0xc631}
                                      : HidIdentity{"SpaceNavigator", play.serial, 0x046d, 0xc626};
  return playToUhid(model, identity, stop, [&](std::int64_t now_ns) {
    const bool hold = (now_ns - start_ns) / 1'000'000'000 % 5 != 4;
    if (hold != held) model.press(hold ? 1 : 0);
    held = hold;
    model.push({static_cast<int>(350 * swing(now_ns, play.period_s)), 0, 0, 0, 0, 0});
    teller.tell(now_ns - start_ns, Vec3::Zero(), Vec3::Zero(),
                fmt::format("\"held\": {}, \"light\": {}", held, model.light()));
  });
}

/** Moves the stick to the right and back. */
Result<void> playPid(const HidPlay& play, const std::atomic<bool>& stop, std::int64_t start_ns) {
  PidVariant variant;
  variant.axes = play.kind == "wheel" ? 1 : 2;
  PidModel model(variant);
  if (auto added = addFaults(play, model, start_ns); !added) return added;
  Teller teller(play.every_s);
  return playToUhid(model, {"OpenFFBoard", play.serial, 0x1209, 0xffb0}, stop, [&](std::int64_t now_ns) {
    model.hand.want(Vec3(0, play.press * swing(now_ns, play.period_s), 0));
    teller.tell(now_ns - start_ns, model.hand.position(), model.force(),
                fmt::format("\"actuators\": {}, \"effects\": {}, \"constants\": {}", model.actuatorsOn(),
                            model.effects(), model.constants()));
  });
}

}  // namespace

Result<void> playHid(const HidPlay& play, const std::atomic<bool>& stop) {
  const std::int64_t start_ns = hapticd::MonotonicClock().now();
  if (play.device == "woodyhid") return playWoody(play, stop, start_ns);
  if (play.device == "spacemouse") return playSpaceMouse(play, stop, start_ns);
  return playPid(play, stop, start_ns);
}

}  // namespace haptic_emu
