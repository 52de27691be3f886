// A question about a tool and one obstacle, both with a volume until a test says otherwise.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "rt/collide/scene_contacts.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd::test {

inline constexpr std::uint32_t kToolEntry = 3, kPlateEntry = 5;

struct Question {
  Question() {
    held.object = makeObjectId(9, 1);
    held.shape.kind = ShapeKind::kMesh;
    held.shape.mesh_entry = kToolEntry;
    held.count = 1;
    held.obstacle[0].slot = 7;
    held.obstacle[0].shape.kind = ShapeKind::kMesh;
    held.obstacle[0].shape.mesh_entry = kPlateEntry;
    volumes.publish(kToolEntry, &ball.view);
    volumes.publish(kPlateEntry, &plate.view);
    contacts->setVolumes(&volumes);
  }
  ContactModel ask(const Vec3& p) {
    held.X_WO.p = p;
    ContactModel model;
    contacts->find(held, 0, {1'000'000, 0, nullptr}, model, report);
    return model;
  }
  double deepest(const ContactModel& model) const {
    double gap = INFINITY;
    for (std::uint32_t i = 0; i < model.count; ++i) {
      gap = std::min(gap, model.touch(i, held.X_WO, held.X_WO.p, held.obstacle[0].X_WO, {}).gap);
    }
    return -gap;
  }

  TestVolume ball = sphereVolume(0.01, 0.0005, 60);
  TestVolume plate = boxVolume({0.02, 0.02, 0.005}, 0.0005);
  VolumeTable volumes;
  CollideRequest::Held held;
  DetectorReport report;
  std::unique_ptr<SceneContacts> contacts = std::make_unique<SceneContacts>();
};

}  // namespace hapticd::test
