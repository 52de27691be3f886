/** @file
 * A daemon stepped by hand in which everything happens at random: scenes, meshes, clients, faults.
 */
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/session/bench.h"
#include "tests/support/random.h"
#include "tests/support/stepped/messages.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {

class Script {
 public:
  explicit Script(unsigned seed) : random(seed), bench(Bench::relaxed(), 2) {
    for (auto* device : bench.scripted) device->sample.fresh = true;
    create("floor", ShapeKind::kBox, Vec3(0.2, 0.2, 0.01), Vec3(0, 0, -0.01));
    mesh(0);
    mesh(HD_MESH_DEFORMABLE);
    for (int i = 0; i < 3; ++i) join();
  }

  void step() {
    moveHands();
    for (const auto& link : bench.core.devices().links()) link->group().step();
    for (auto& c : clients) {
      if (!random.once(400)) c.side->producer->heartbeat(bench.clock.now());
      if (random.once(3000)) c.silent_until_ns = bench.clock.now() + 400 * kMs;
    }
    bench.core.poll();
    for (std::uint32_t d = 0; d < 2; ++d) {
      const DeviceCommand& sent = bench.scripted[d]->sent.back();
      pressed += sent.enabled && sent.force.norm() > 0.05 ? 1 : 0;
    }
  }

  /** One thing that somebody does. */
  void act() {
    switch (random.below(16)) {
      case 0:
        return create("o" + std::to_string(++made_), static_cast<ShapeKind>(1 + random.below(5)),
                      Vec3(0.01, 0.015, 0.02), random.vector(0.04));
      case 1:
        if (const std::string name = someObject(); name != "floor") (void)bench.core.scene().remove(name, root());
        return;
      case 2:
        (void)bench.core.scene().setPose(someObject(), {random.vector(0.04), Quat::Identity()});
        return;
      case 3:
        (void)bench.core.scene().setVelocity(someObject(), {random.vector(0.05), random.vector(1)});
        return;
      case 4:
        if (random.once(4)) mesh(random.once(2) ? HD_MESH_DEFORMABLE : 0);
        return;
      case 5: {
        const auto meshes = bench.core.meshes().list();
        if (!meshes.empty() && random.once(3))
          (void)bench.core.meshes().drop(
              meshes[static_cast<std::size_t>(random.below(static_cast<int>(meshes.size())))]->id, root());
        return;
      }
      case 6:
        if (random.once(6)) join();
        return;
      case 7:
        if (random.once(6)) leave();
        return;
      case 8:
      case 11:
        if (Session* session = someSession()) bench.core.arm(session->id, [](Result<void>) {});
        return;
      case 9:
        if (random.once(60)) (void)bench.core.stop("", bench.administration);
        return;
      case 10:
        if (random.once(4)) {
          GuardLimits limits;
          limits.force = random.in(1, 6);
          limits.force_slew = 500;
          limits.torque_slew = 50;
          limits.velocity = 1;
          limits.power = random.in(1, 10);
          limits.active_power = 5;
          (void)bench.core.setLimits("", limits, bench.administration);
        }
        return;
      default:
        return say();
    }
  }

  /** Sets up a device elsewhere. It must be disarmed. */
  void mount(std::size_t device, const Pose& X_WD) {
    EXPECT_TRUE(bench.core.setMount(bench.device(device), X_WD, root()).ok());
  }

  void disarmAll() {
    for (const auto& device : bench.core.devices().devices()) {
      if (device->lease != 0) (void)bench.core.disarm(device->lease);
    }
    for (int i = 0; i < 1200; ++i) step();  // lowering takes a second at most
  }

  Random random;
  Bench bench;
  long pressed = 0;  ///< Ticks in which a hand felt something.

 private:
  struct Party {
    std::uint64_t session = 0;
    std::unique_ptr<ClientSide> side;
    std::int64_t silent_until_ns = 0;
  };

  [[nodiscard]] Client root() { return bench.core.client(bench.administration); }

  void create(const std::string& name, ShapeKind kind, const Vec3& size, const Vec3& p, std::uint64_t mesh_id = 0) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {kind, size, mesh_id};
    if (kind == ShapeKind::kPlane) spec.X_PO.p = Vec3(0, 0, -0.02);
    if (kind != ShapeKind::kPlane) spec.X_PO.p = p;
    spec.material = {800, 1, 0.6, 0.4};
    if (made_ % 4 == 3) spec.parent = someObject();
    (void)bench.core.scene().create(std::move(spec), root());
  }

  void mesh(std::uint32_t flags) {
    BuildMonitor monitor;
    auto snapshot = buildSnapshot(upload(torus(12, 8), flags), monitor);
    ASSERT_TRUE(snapshot.ok());
    MeshInfo info;
    info.owner = root();
    auto fd = snapshot->memfd.share();
    ASSERT_TRUE(fd.ok());
    auto id = bench.core.meshes().add(std::move(*fd), info);
    if (id) create("m" + std::to_string(++made_), ShapeKind::kMesh, Vec3::Zero(), random.vector(0.02), *id);
  }

  void join() {
    auto session = bench.core.openSession(random.once(2) ? "test://first" : "test://second", bench.connection, "party",
                                          HD_SHM_MAJOR, HD_SHM_MINOR);
    if (!session) return;
    clients.push_back({(*session)->id, std::make_unique<ClientSide>(**session)});
    clients.back().side->producer->heartbeat(bench.clock.now());
    (void)bench.core.sessions().mapped((*session)->id);
  }

  void leave() {
    if (clients.size() < 2) return;
    const auto i = clients.begin() + random.below(static_cast<int>(clients.size()));
    bench.core.sessions().end(i->session, "the script says so");
    clients.erase(i);
  }

  Session* someSession() {
    if (clients.empty()) return nullptr;
    return bench.core.sessions().find(
        clients[static_cast<std::size_t>(random.below(static_cast<int>(clients.size())))].session);
  }

  std::string someObject() {
    const auto names = bench.core.scene().names();
    return names.empty() ? "" : names[static_cast<std::size_t>(random.below(static_cast<int>(names.size())))];
  }

  /** A client's message of any kind, about an object that may exist, now or later. */
  void say() {
    if (clients.empty()) return;
    Party& party = clients[static_cast<std::size_t>(random.below(static_cast<int>(clients.size())))];
    std::vector<Message> messages = goodMessages();
    hd_slot slot = messages[static_cast<std::size_t>(random.below(static_cast<int>(messages.size())))].slot;
    const auto object = bench.core.scene().find(someObject());
    const std::uint32_t id = object ? object->id : 0;
    adapt(slot, id);
    const std::uint64_t tick = bench.core.devices().links().front()->group().servo().counters.tick.load();
    std::uint64_t seq = 0;
    (void)party.side->producer->push(slot.kind, std::as_bytes(std::span(slot.payload, slot.length)),
                                     random.once(4) ? tick + static_cast<std::uint64_t>(random.below(60)) : 0, seq);
  }

  /** Makes it about that object and near the hands. */
  void adapt(hd_slot& slot, std::uint32_t id) {
    const auto edit = [&slot](auto payload, auto&& change) {
      std::memcpy(&payload, slot.payload, sizeof payload);
      change(payload);
      std::memcpy(slot.payload, &payload, sizeof payload);
    };
    switch (slot.kind) {
      case HD_COMMAND_OBJECT_POSE:
        return edit(hd_object_pose{}, [&](auto& x) {
          x.object = id;
          store(random.vector(0.03), x.p);
          store(random.vector(0.1), x.v);
        });
      case HD_COMMAND_OBJECT_MATERIAL:
        return edit(hd_object_material{}, [&](auto& x) { x.object = id; });
      case HD_COMMAND_OBJECT_FLAGS:
        return edit(hd_object_flags{}, [&](auto& x) {
          x.object = id;
          x.value = random.once(4) ? 0 : HD_OBJECT_ENABLED;
        });
      case HD_COMMAND_OBJECT_VERTICES:
        return edit(hd_object_vertices{}, [&](auto& x) {
          x.object = id;
          for (std::uint32_t i = 0; i < x.count; ++i) {
            x.move[i].index = static_cast<std::uint32_t>(random.below(96));
            for (float& p : x.move[i].p) p = static_cast<float>(random.in(-0.05, 0.05));
          }
        });
      case HD_COMMAND_LOCAL_MODEL:
        return edit(hd_local_model{}, [&](auto& x) {
          x.slot = static_cast<std::uint32_t>(random.below(3));
          x.frame = random.once(3) ? id : 0;
          x.device = static_cast<std::uint32_t>(random.below(2));
          x.lease_ns = static_cast<std::int64_t>(1 + random.below(300)) * kMs;
          store(random.vector(0.01), x.origin);
        });
      case HD_COMMAND_FORCE_FIELD:
        return edit(hd_force_field{}, [&](auto& x) { x.frame = random.once(3) ? id : 0; });
      default:
        return;
    }
  }

  void moveHands() {
    for (auto* device : bench.scripted) {
      DeviceSample& sample = device->sample;
      if (random.once(40)) sample.v = random.vector(0.3);
      sample.p += 1e-3 * sample.v - 0.002 * sample.p;
      sample.fresh = !random.once(50);
      sample.status = random.once(4000) ? kDeviceError : kDeviceOk;
      if (random.once(300)) sample.buttons ^= 1u;
      if (random.once(5000)) sample.p.x() = random.broken();
      if (!isFinite(sample.p)) broken_ = 3;
      if (broken_ > 0 && --broken_ == 0) sample.p.setZero();
    }
    auto& servo = bench.core.devices().links().front()->group().servo();
    servo.stop_line = random.once(2000);
    servo.deadman_open = random.once(2000);
    if (random.once(1000)) bench.clock.advance(random.below(60) * kMs);
  }

  int made_ = 0, broken_ = 0;

 public:
  std::vector<Party> clients;
};

}  // namespace hapticd::test
