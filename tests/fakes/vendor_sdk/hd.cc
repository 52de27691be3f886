// OpenHaptics' side of the fake.
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <thread>

#include "fake_sdk.h"

namespace {

fake_sdk::State& s() { return *fake_sdk_state(); }

using Callback = unsigned int (*)(void*);
struct Scheduler {
  std::atomic<Callback> callback{nullptr};
  std::atomic<void*> user{nullptr};
  std::atomic<bool> running{false};
  std::thread thread;
};
Scheduler scheduler;
unsigned error_waiting = 0;
bool in_frame = false;
double told[3] = {};
constexpr unsigned kDevice = 7;

void apply() {
  for (int i = 0; i < 3; ++i) s().force[i] = s().force_on ? told[i] : 0;
}

}  // namespace

extern "C" {
struct ErrorInfo {
  unsigned int code;
  int internal;
  unsigned int device;
};

unsigned int hdInitDevice(const char* name) {
  const bool known = name == nullptr || std::strcmp(name, "Left") == 0;
  if (!known || s().unplugged || s().silent || fake_sdk::held()) {
    error_waiting = 0x302;
    return 0xFFFFFFFF;
  }
  fake_sdk::hold(true);
  ++s().opened;
  return kDevice;
}
void hdDisableDevice(unsigned int) {
  fake_sdk::hold(false);
  ++s().closed;
  s().force_on = false;
  apply();
}
void hdMakeCurrentDevice(unsigned int) {}
void hdBeginFrame(unsigned int) {
  while (s().hangs) ::usleep(1000);
  ++s().calls;
  in_frame = true;
  if (s().unplugged) error_waiting = 0x302;
  if (const unsigned error = s().hd_error.exchange(0)) error_waiting = error;
  if (s().failing && s().calls % 5 == 0) error_waiting = 0x204;
}
void hdEndFrame(unsigned int) {
  in_frame = false;
  if (!s().unplugged) apply();
  ++s().force_calls;
  if (const unsigned error = s().hd_force_error.exchange(0)) error_waiting = error;
}
ErrorInfo hdGetError() {
  const unsigned code = error_waiting;
  error_waiting = 0;
  return {code, 0, kDevice};
}
const char* hdGetErrorString(unsigned int) { return "the played reason"; }
void hdEnable(unsigned int what) {
  if (what == 0x4000) s().force_on = true;
}
void hdDisable(unsigned int what) {
  if (what == 0x4000) s().force_on = false;
  apply();
}
void hdGetDoublev(unsigned int what, double* out) {
  if ((what == 0x2050 || what == 0x2052) && !in_frame) ++s().frames_outside;
  const double place[3] = {
      s().place[0] + (s().jumping ? 2000 : 0), s().place[1],
      s().garbled && s().calls % 7 == 0 ? std::numeric_limits<double>::infinity() : s().place[2].load()};
  const double usable[6] = {-80, -60, -35, 80, 60, 35}, most[6] = {-210, -110, -85, 210, 205, 130};
  if (what == 0x2050) std::memcpy(out, place, sizeof place);
  if (what == 0x2555 || what == 0x2500) std::abort();  // Not doubles.
  if (what == 0x2550) std::memcpy(out, most, sizeof most);
  if (what == 0x2551) std::memcpy(out, usable, sizeof usable);
  if (what == 0x2602) *out = 0.4;
  if (what == 0x2603) *out = 3.3;
  if (what == 0x2604) *out = 0.88;
  if (what == 0x2609) *out = 0.002;
  if (what != 0x2052) return;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out[4 * column + row] = s().rotation[3 * row + column];
    out[4 * row + 3] = 0;
    out[12 + row] = place[row];
  }
  out[15] = 1;
}
void hdGetIntegerv(unsigned int what, int* out) {
  const int styles = s().hd_styles;
  *out = what == 0x2000 ? static_cast<int>(s().buttons) : styles == 0 ? 4 : styles;
}
const char* hdGetString(unsigned int what) {
  if (what == 0x2500) return s().version_major == 3 ? "3.40.0" : "2.10.0";
  return what == 0x2504 ? "T1234" : what == 0x2501 ? "played Touch" : "1";
}
void hdSetDoublev(unsigned int what, const double* values) {
  if (!in_frame) ++s().frames_outside;
  if (what == 0x2700) std::memcpy(told, values, sizeof told);
}
unsigned int hdCheckCalibration() { return s().calibrated ? 0x5000 : s().buttons == 8 ? 0x5001 : 0x5002; }
void hdUpdateCalibration(unsigned int style) {
  const bool one = style == 1 || style == 2 || style == 4;
  s().calibrated = one;
  s().hd_calibrated_by = static_cast<int>(style);
  if (!one) error_waiting = 0x100;
}
unsigned long hdScheduleAsynchronous(Callback callback, void* user, unsigned short) {
  scheduler.user = user;
  scheduler.callback = callback;
  return 42;
}
#ifndef FAKE_SDK_OLD
void hdUnschedule(unsigned long) { scheduler.callback = nullptr; }
#endif
void fake_sdk_tick() {
  const Callback callback = scheduler.callback;
  if (scheduler.running && callback != nullptr && !s().silent) (void)callback(scheduler.user);
}
void hdStartScheduler() {
  scheduler.running = true;
  if (std::getenv("FAKE_SDK_THREAD") == nullptr) return;
  scheduler.thread = std::thread([] {
    while (scheduler.running) {
      fake_sdk_tick();
      ::usleep(1000);
    }
  });
}
void hdStopScheduler() {
  scheduler.running = false;
  if (scheduler.thread.joinable()) scheduler.thread.join();
}
}
