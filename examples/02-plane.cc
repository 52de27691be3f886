// 02: plane and probe. The program knows a curved surface (a hill); fifty times a second it sends the plane that
// touches the hill below the hand, and the servo renders that plane at full rate. Slow programs feel hard surfaces this
// way. WARNING: the device moves. Keep the workspace free and hold the handle.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <hapticclient/hapticclient.hpp>
#include <iostream>
#include <thread>

using namespace std::chrono_literals;

static int fail(const haptic::Error& error) { return std::cerr << error.message() << '\n', 1; }

int main() {
  auto client = haptic::Client::connect();
  if (!client) return fail(client.error());
  auto session = client->openSession();
  if (!session) return fail(session.error());
  if (auto armed = session->arm(); !armed) return fail(armed.error());

  constexpr double kRadius = 0.1;  // of the hill, whose top is the origin
  constexpr double kCentre[3] = {0, 0, -kRadius};
  double felt = 0;
  for (int i = 0; i < 500 && felt < 1; ++i, std::this_thread::sleep_for(20ms)) {
    const auto sample = session->latest();
    if (!sample) continue;

    haptic_local_model plane = HAPTIC_LOCAL_MODEL_INIT;
    plane.kind = HAPTIC_MODEL_PLANE;
    plane.lease_ns = 200'000'000;  // if this program stalls longer than this, the plane fades away
    plane.blend_ns = 20'000'000;   // the old plane turns into the new one without a jump in force
    plane.material = {800, 1, 0.4, 0.3};
    double n[3], length = 0;
    for (int k = 0; k < 3; ++k) length += std::pow(n[k] = sample->p[k] - kCentre[k], 2);
    length = std::sqrt(length);
    for (int k = 0; k < 3; ++k) plane.origin[k] = kCentre[k] + kRadius * (plane.normal[k] = n[k] / length);
    if (auto pushed = session->push(plane, {.latest = true}); !pushed) return fail(pushed.error());

    haptic_intent hand = HAPTIC_INTENT_INIT;  // what a simulated hand wants: to press and stroke; a real one ignores it
    hand.p[1] = 0.02 * std::sin(0.1 * i);
    hand.p[2] = 0.03 - 0.04 * std::min(1.0, i / 50.0);
    (void)session->push(hand, {.latest = true});

    const float* f = sample->by_source[HAPTIC_SOURCE_LOCAL_MODEL];
    felt = std::max(felt, std::hypot(double{f[0]}, double{f[1]}, double{f[2]}));
  }
  std::cout << "felt " << felt << " N of the hill\n";
  return felt >= 1 ? 0 : 1;
}
