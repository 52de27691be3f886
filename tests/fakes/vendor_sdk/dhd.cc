// Force Dimension's side of the fake.
#include <unistd.h>

#include <limits>

#include "fake_sdk.h"

namespace {

fake_sdk::State& s() { return *fake_sdk_state(); }
double told[3] = {};
constexpr int kOk = 0, kError = -1, kId = 2;

/** Whether a call reaches the device. */
bool reaches(char id) {
  const std::uint64_t call = ++s().calls;
  while (s().hangs) ::usleep(1000);
  if (id != kId || !fake_sdk::held() || s().unplugged || s().silent) return false;
  return !(s().failing && call % 5 == 0);
}
int opens() {
  if (s().unplugged || s().silent || fake_sdk::held()) return kError;
  fake_sdk::hold(true);
  ++s().opened;
  return kId;
}
void push(const double* force, const double* torque, double gripper) {
  const bool on = s().force_on && !s().forces_refused;
  for (int i = 0; i < 3; ++i) {
    s().force[i] = on ? force[i] : 0;
    s().torque[i] = on ? torque[i] : 0;
  }
  s().gripper_force = on ? gripper : 0;
  for (int i = 0; i < 3; ++i) told[i] = force[i];
}

}  // namespace

extern "C" {
void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = s().version_major;
  *minor = 17;
  *release = *revision = 0;
}
int dhdOpen() { return opens(); }
int dhdOpenID(char index) { return index == 0 ? opens() : kError; }
int dhdOpenSerial(int serial) { return serial == 1234 ? opens() : kError; }
int dhdClose(char) {
  if (told[0] != 0 || told[1] != 0 || told[2] != 0) ++s().closed_pushing;  // It may hold what it was told last.
  fake_sdk::hold(false);
  ++s().closed;
  return kOk;
}
int dhdStop(char) {
  s().force_on = false;
  for (auto& force : s().force) force = 0;
  return kOk;
}
int dhdGetSystemType(char) { return s().system_type; }
const char* dhdGetSystemName(char) { return "played omega"; }
int dhdGetSerialNumber(unsigned short* serial, char) {
  *serial = 1234;
  return kOk;
}
int dhdGetStatus(int* status, char id) {
  if (!reaches(id)) return kError;
  for (int i = 0; i < 17; ++i) status[i] = 0;
  status[0] = status[1] = 1;
  status[3] = s().calibrated ? 1 : 0;
  status[5] = s().force_on && !s().forces_refused ? 1 : 0;
  return kOk;
}
bool dhdHasWrist(char) { return s().system_type >= 34; }
bool dhdHasActiveWrist(char) { return s().system_type >= 104; }
bool dhdHasGripper(char) { return s().system_type >= 104; }
bool dhdHasActiveGripper(char) { return s().system_type >= 104; }
bool dhdIsLeftHanded(char) { return s().system_type == 105; }
int dhdEnableForce(unsigned char on, char) {
  if (on == 0 && s().stuck_on) return kError;
  s().force_on = on != 0;
  for (auto& force : s().force) force = on == 0 ? 0 : force.load();
  return kOk;
}
int dhdSetGravityCompensation(int on, char) {
  s().gravity_on = on;
  return kOk;
}
int dhdGetPosition(double* x, double* y, double* z, char id) {
  if (!reaches(id)) return kError;
  const std::uint64_t call = s().calls;
  *x = s().place[0] + (s().jumping ? 0.7 : 0);
  *y = s().place[1];
  *z = s().garbled && call % 7 == 0 ? std::numeric_limits<double>::quiet_NaN() : s().place[2].load();
  return kOk;
}
int dhdGetOrientationFrame(double (*rows)[3], char id) {
  if (!reaches(id)) return kError;
  for (int i = 0; i < 9; ++i) rows[i / 3][i % 3] = s().rotation[i];
  return kOk;
}
int dhdGetGripperAngleRad(double* angle, char id) {
  *angle = s().gripper_rad;
  return reaches(id) ? kOk : kError;
}
unsigned int dhdGetButtonMask(char) { return s().buttons; }
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double fg,
                                        char id) {
  ++s().force_calls;
  if (id != kId || s().unplugged || s().deaf) return kError;  // A silent device still hears.
  const double force[3] = {fx, fy, fz}, torque[3] = {tx, ty, tz};
  push(force, torque, fg);
  return s().saturating ? 2 : s().force_calls % 3 == 0 ? 1 : kOk;  // 1: told again too soon, which is no error.
}
#ifndef FAKE_SDK_OLD
const char* dhdErrorGetLastStr() { return s().unplugged ? "no device found" : "the played reason"; }
#endif
}
