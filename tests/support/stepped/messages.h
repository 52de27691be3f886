/** @file
 * Well-formed client messages, one per kind and model, to be sent or broken by tests.
 */
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "proto/shm_layout.h"

namespace hapticd::test {

struct Message {
  std::string name;
  hd_slot slot;
};

template <class T>
hd_slot slotOf(std::uint32_t kind, const T& payload, std::uint64_t seq = 1) {
  static_assert(sizeof(T) <= sizeof(hd_slot::payload));
  hd_slot slot{};
  slot.kind = kind;
  slot.length = sizeof payload;
  slot.seq = seq;
  std::memcpy(slot.payload, &payload, sizeof payload);
  return slot;
}

inline constexpr hd_material kRubber{800, 1.5, 0.6, 0.4};

inline hd_object_pose goodPose() { return {65537, 0, {0.1, -0.2, 0.3}, {0.6, 0, 0.8, 0}, {1, 2, 3}, {4, 5, 6}}; }
inline hd_object_material goodMaterial() { return {65537, 0, kRubber}; }
inline hd_object_flags goodFlags() { return {65537, HD_OBJECT_ENABLED | HD_OBJECT_VISIBLE, HD_OBJECT_ENABLED, 0}; }
inline hd_object_vertices goodVertices() {
  hd_object_vertices x{65537, 3, {}};
  for (std::uint32_t i = 0; i < x.count; ++i) x.move[i] = {i, {0.1f, 0.2f, -0.3f}};
  return x;
}
inline hd_local_model goodModel(hd_model_kind kind) {
  hd_local_model x{};
  x.slot = 7;
  x.kind = kind;
  x.lease_ns = 100'000'000;
  x.blend_ns = 10'000'000;
  x.material = kRubber;
  x.origin[2] = 0.05;
  if (kind == HD_MODEL_PLANE) x.normal[2] = 1;
  if (kind == HD_MODEL_SPRING) x.radius = 0.01;
  if (kind == HD_MODEL_SPHERE) x.radius = -0.05;
  if (kind == HD_MODEL_HALFSPACES || kind == HD_MODEL_CORNER) {
    x.count = 2;
    x.halfspace[0][2] = 1;
    x.halfspace[1][0] = 0.6f;
    x.halfspace[1][1] = -0.8f;
    x.halfspace[1][3] = 0.02f;
  }
  return x;
}
inline hd_force_field goodField() {
  hd_force_field x{};
  x.slot = 1;
  x.lease_ns = 50'000'000;
  x.blend_ns = 0;
  x.f0[0] = 2;
  for (int i = 0; i < 9; ++i) x.jacobian[i] = i % 4 == 0 ? -300 : 5;
  x.radius = 0.02;
  return x;
}
inline hd_clear_model goodClear() { return {2, 0, 5'000'000}; }
inline hd_client_force goodForce() { return {0, 0, 20'000'000, {1, -2, 0.5}, {0.01, 0, 0}}; }
inline hd_intent goodIntent() { return {0, 0, {0.01, 0, 0.02}, {1, 0, 0, 0}, 0.2}; }
inline hd_limits goodLimits() { return {3.5, 0.1}; }

/** All of them. */
inline std::vector<Message> goodMessages() {
  return {{"pose", slotOf(HD_COMMAND_OBJECT_POSE, goodPose())},
          {"material", slotOf(HD_COMMAND_OBJECT_MATERIAL, goodMaterial())},
          {"flags", slotOf(HD_COMMAND_OBJECT_FLAGS, goodFlags())},
          {"vertices", slotOf(HD_COMMAND_OBJECT_VERTICES, goodVertices())},
          {"plane", slotOf(HD_COMMAND_LOCAL_MODEL, goodModel(HD_MODEL_PLANE))},
          {"spring", slotOf(HD_COMMAND_LOCAL_MODEL, goodModel(HD_MODEL_SPRING))},
          {"sphere", slotOf(HD_COMMAND_LOCAL_MODEL, goodModel(HD_MODEL_SPHERE))},
          {"halfspaces", slotOf(HD_COMMAND_LOCAL_MODEL, goodModel(HD_MODEL_HALFSPACES))},
          {"corner", slotOf(HD_COMMAND_LOCAL_MODEL, goodModel(HD_MODEL_CORNER))},
          {"field", slotOf(HD_COMMAND_FORCE_FIELD, goodField())},
          {"clear", slotOf(HD_COMMAND_CLEAR_MODEL, goodClear())},
          {"force", slotOf(HD_COMMAND_CLIENT_FORCE, goodForce())},
          {"intent", slotOf(HD_COMMAND_INTENT, goodIntent())},
          {"limits", slotOf(HD_COMMAND_LIMITS, goodLimits())}};
}

}  // namespace hapticd::test
