/** @file
 * A snapshot in the daemon's memory: mapped, checked, locked, ready for the servo.
 */
#pragma once

#include <vector>

#include "daemon/ipc/memfd.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/** Owns the memory that `view` points into. The servo must have passed before it goes. */
struct SnapshotMemory {
  Mapping mapping;
  Mapping motion;  ///< Of the vertices, if they can be moved.
  MeshView view;
};

/** Memory for how the vertices of a deformable mesh move, to which `view` then points; none for a rigid one. */
[[nodiscard]] Result<Mapping> addMotion(MeshView& view);

/**
 * Takes a snapshot that the builder (or a cache file's copy) made: requires Seals::kFrozen, maps it (a private copy if
 * deformable), validates all of it and, if `lock`, locks it. Any thread; 60 ms for a million triangles, and more where
 * pages are dear.
 */
[[nodiscard]] Result<SnapshotMemory> openSnapshot(UniqueFd fd, bool lock);

/**
 * Another servo's own copy of a deformable snapshot, as the builder made it: of `fd`, of which `checked` was opened.
 * What is sealed is not checked again, which takes half as long.
 */
[[nodiscard]] Result<SnapshotMemory> copySnapshot(UniqueFd fd, const SnapshotMemory& checked, bool lock);

/** What moved vertices change of a snapshot, into a copy of it as it was; then closeDeformed() is due. */
void copyMoved(std::span<const std::byte> snapshot, std::span<std::byte> copy) noexcept;

/** Makes a copy of a snapshot whose vertices have been moved whole again: with the box and the checksum it has now. */
void closeDeformed(std::span<std::byte> copy) noexcept;

}  // namespace hapticd
