// 04: a force of the program's own, computed a hundred times a second: a well that draws the hand to a point. Each push
// carries the force where the hand is now and its Jacobian, so that the servo has the right force between two pushes as
// well; a force alone would lag behind the hand and make it shake.
// WARNING: the device moves. Keep the workspace free and hold the handle.
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

  constexpr double kStiffness = 150, kWidth = 0.03, kCentre[3] = {0, 0.02, 0};
  double felt = 0;
  for (int i = 0; i < 1000 && felt < 0.5; ++i, std::this_thread::sleep_for(10ms)) {
    const auto sample = session->latest();
    if (!sample) continue;

    // F = -k d / (1 + |d|^2 / s^2), d the way from the centre: a spring near it, weaker far away.
    double d[3], square = 0;
    for (int k = 0; k < 3; ++k) square += std::pow(d[k] = sample->p[k] - kCentre[k], 2);
    const double g = 1 / (1 + square / (kWidth * kWidth));
    haptic_force_field field = HAPTIC_FORCE_FIELD_INIT;
    field.lease_ns = 100'000'000;  // without news for this long the force fades away
    field.blend_ns = 10'000'000;
    field.radius = 0.01;  // how far from x0 the Jacobian is trusted
    for (int r = 0; r < 3; ++r) {
      field.x0[r] = sample->p[r];
      field.f0[r] = -kStiffness * g * d[r];
      for (int c = 0; c < 3; ++c) {
        field.jacobian[3 * r + c] = kStiffness * g * (2 * g * d[r] * d[c] / (kWidth * kWidth) - (r == c ? 1 : 0));
      }
    }
    if (auto pushed = session->push(field, {.latest = true}); !pushed) return fail(pushed.error());

    const haptic_intent hand = HAPTIC_INTENT_INIT;  // a simulated hand holds the middle and is drawn aside
    (void)session->push(hand, {.latest = true});
    felt = sample->by_source[HAPTIC_SOURCE_LOCAL_MODEL][1];
  }
  std::cout << "drawn with " << felt << " N\n";
  return felt >= 0.5 ? 0 : 1;
}
