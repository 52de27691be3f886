// 03: a mesh. Makes a ring of triangles, has the daemon build it, puts it into the scene and feels it. From then on the
// daemon needs nothing from this program: it renders the mesh by itself.
// WARNING: the device moves. Keep the workspace free and hold the handle.
#include <chrono>
#include <cmath>
#include <hapticclient/hapticclient.hpp>
#include <iostream>
#include <numbers>
#include <thread>
#include <vector>

using namespace std::chrono_literals;

static int fail(const haptic::Error& error) { return std::cerr << error.message() << '\n', 1; }

int main() {
  constexpr unsigned kSides = 64;
  constexpr double kRing = 0.03, kTube = 0.015, kTurn = 2 * std::numbers::pi / kSides;
  std::vector<float> vertices;           // x, y, z [m]
  std::vector<std::uint32_t> triangles;  // corners counter-clockwise seen from outside
  for (unsigned i = 0; i < kSides; ++i) {
    for (unsigned k = 0; k < kSides; ++k) {
      const double r = kRing + kTube * std::cos(k * kTurn);
      for (const double x : {r * std::cos(i * kTurn), r * std::sin(i * kTurn), kTube * std::sin(k * kTurn)})
        vertices.push_back(static_cast<float>(x));
      const unsigned a = i * kSides + k, b = (i + 1) % kSides * kSides + k;
      const unsigned c = i * kSides + (k + 1) % kSides, d = (i + 1) % kSides * kSides + (k + 1) % kSides;
      triangles.insert(triangles.end(), {a, b, c, b, d, c});
    }
  }

  auto client = haptic::Client::connect();
  if (!client) return fail(client.error());
  auto session = client->openSession();
  if (!session) return fail(session.error());
  auto mesh = client->scene().upload(vertices, triangles);
  if (!mesh) return fail(mesh.error());
  std::cout << (*mesh)->triangles << " triangles, " << ((*mesh)->closed ? "closed" : "open") << '\n';

  haptic_object ring = HAPTIC_OBJECT_INIT;
  ring.name = "ring";
  ring.pose.p[0] = -kRing;  // the tube passes under the middle of the workspace,
  ring.pose.p[2] = -0.025;  // its top 1 cm below
  ring.shape.kind = HAPTIC_SHAPE_MESH;
  ring.shape.mesh = (*mesh)->id;
  ring.material = {1000, 1, 0.4, 0.3};
  auto object = client->scene().create(ring);  // removed when `object` ends
  if (!object) return fail(object.error());
  if (auto armed = session->arm(); !armed) return fail(armed.error());

  double felt = 0;
  for (int i = 0; i < 500 && felt < 1; ++i, std::this_thread::sleep_for(20ms)) {
    haptic_intent hand = HAPTIC_INTENT_INIT;  // of a simulated hand: press down
    hand.p[2] = i < 10 ? 0.0 : -0.02;
    (void)session->push(hand, {.latest = true});
    if (auto sample = session->latest()) felt = sample->by_source[HAPTIC_SOURCE_SURFACE][2];
  }
  std::cout << "felt " << felt << " N upward from the ring\n";
  return felt >= 1 ? 0 : 1;
}
