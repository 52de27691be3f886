/** @file
 * Objects and meshes. Object and Upload end with their scope. A Scene or Object whose Client is gone refuses every
 * call.
 */
#pragma once

#include <hapticclient/scene.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <hapticclient/descriptor.hpp>
#include <hapticclient/result.hpp>
#include <memory>
#include <span>
#include <string>
#include <utility>

namespace haptic {

/** Told how far a build is, now and then the same again; false cancels it. What it throws ends the call with
 * HAPTIC_INTERNAL. */
using Progress = std::function<bool(float fraction, const char* stage)>;

namespace detail {
inline int callProgress(float fraction, const char* stage, void* user) {
  return (*static_cast<const Progress*>(user))(fraction, stage) ? 0 : 1;
}

/** Of the daemon last connected to; 0: none can be told. */
inline std::uint64_t epochOf(haptic_client* client) noexcept {
  haptic_daemon_info* info = nullptr;
  if (haptic_get_daemon_info(client, &info, nullptr) != HAPTIC_OK) return 0;
  return Reply<haptic_daemon_info>(info)->epoch;
}
}  // namespace detail

/** A mesh being filled in the daemon's memory. Destroyed uncommitted, it is cancelled. */
class Upload {
 public:
  Upload(haptic_upload* handle, std::uint32_t vertices, std::uint32_t triangles) noexcept
      : handle_(handle), vertices_(vertices), triangles_(triangles) {}

  /** x, y, z of each vertex [m]; empty once committed. */
  [[nodiscard]] std::span<float> vertices() const noexcept {
    float* first = haptic_upload_vertices(handle_.get());
    return {first, first == nullptr ? 0 : std::size_t{vertices_} * 3};
  }
  /** Three indices of each triangle, counter-clockwise seen from outside; empty once committed. */
  [[nodiscard]] std::span<std::uint32_t> triangles() const noexcept {
    std::uint32_t* first = haptic_upload_triangles(handle_.get());
    return {first, first == nullptr ? 0 : std::size_t{triangles_} * 3};
  }
  /** Vertices no farther apart than `distance_m` become one; without it only equal ones do. */
  Result<void> weld(double distance_m) {
    return detail::run([&](auto* e) { return haptic_upload_weld(handle_.get(), distance_m, e); });
  }
  /** Of a mesh begun with HAPTIC_MESH_VOLUME: side of its voxels, distance of its surface points (0: a voxel). */
  Result<void> volume(double voxel_m, double point_spacing_m = 0) {
    return detail::run([&](auto* e) { return haptic_upload_volume(handle_.get(), voxel_m, point_spacing_m, e); });
  }
  Result<Reply<haptic_mesh_report>> commit(const Progress& progress = {}, std::chrono::nanoseconds timeout = {}) {
    return detail::ask<haptic_mesh_report>([&](auto** out, auto* e) {
      return haptic_upload_commit(handle_.get(), progress ? detail::callProgress : nullptr,
                                  const_cast<Progress*>(&progress), timeout.count(), out, e);
    });
  }

 private:
  struct Close {
    void operator()(haptic_upload* handle) const noexcept { haptic_upload_close(handle); }
  };
  std::unique_ptr<haptic_upload, Close> handle_;
  std::uint32_t vertices_, triangles_;
};

/**
 * An object of the scene that is removed with this handle, unless released. One that has taken its name since, made
 * anew or in a restarted daemon, stays.
 */
class Object {
 public:
  /** `epoch`: of the daemon that made it. */
  Object(std::weak_ptr<haptic_client> client, std::string name, std::uint32_t id, std::uint64_t epoch)
      : client_(std::move(client)), name_(std::move(name)), id_(id), epoch_(epoch) {}
  Object(Object&& other) noexcept = default;  // a weak pointer that was moved from is empty
  Object& operator=(Object&& other) noexcept {
    std::swap(client_, other.client_);
    std::swap(name_, other.name_);
    std::swap(id_, other.id_);
    std::swap(epoch_, other.epoch_);
    std::swap(removes_, other.removes_);
    return *this;
  }
  ~Object() {
    if (const auto client = client_.lock(); client && removes_ && stands(client.get()))
      haptic_object_remove(client.get(), name_.c_str(), nullptr);
  }

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  /** For pushes. */
  [[nodiscard]] std::uint32_t id() const noexcept { return id_; }
  /** Leaves the object in the scene, until its client leaves unless it was made with HAPTIC_OBJECT_KEEP. */
  void release() noexcept { removes_ = false; }

  Result<void> setPose(const haptic_pose& pose) {
    return detail::run([&](auto* e) { return haptic_object_set_pose(client_.lock().get(), name_.c_str(), &pose, e); });
  }
  Result<void> setMaterial(const haptic_material& material) {
    return detail::run(
        [&](auto* e) { return haptic_object_set_material(client_.lock().get(), name_.c_str(), &material, e); });
  }
  Result<void> setSurface(const haptic_surface& surface) {
    return detail::run(
        [&](auto* e) { return haptic_object_set_surface(client_.lock().get(), name_.c_str(), &surface, e); });
  }
  /** All of it at once, or nothing. `path`, if there is one, in place of effect.path: x, y, z of each point [m]. */
  Result<void> setEffect(haptic_effect effect, std::span<const std::array<double, 3>> path = {}) {
    if (!path.empty()) {
      effect.path = path.front().data();
      effect.path_count = static_cast<std::uint32_t>(path.size());
    }
    return detail::run(
        [&](auto* e) { return haptic_object_set_effect(client_.lock().get(), name_.c_str(), &effect, e); });
  }
  /** Whether it is kept stays as when it was made. */
  Result<void> setFlags(std::uint32_t flags) {
    return detail::run([&](auto* e) { return haptic_object_set_flags(client_.lock().get(), name_.c_str(), flags, e); });
  }
  Result<void> setShape(const haptic_shape& shape) {
    return detail::run(
        [&](auto* e) { return haptic_object_set_shape(client_.lock().get(), name_.c_str(), &shape, e); });
  }
  [[nodiscard]] Result<Reply<haptic_object_state>> state() const {
    return detail::ask<haptic_object_state>(
        [&](auto** out, auto* e) { return haptic_object_find(client_.lock().get(), name_.c_str(), out, e); });
  }

 private:
  /** Whether what bears the name is what this handle made: numbers are given out anew by each daemon. */
  [[nodiscard]] bool stands(haptic_client* client) const noexcept {
    haptic_object_state* state = nullptr;
    if (detail::epochOf(client) != epoch_ || haptic_object_find(client, name_.c_str(), &state, nullptr) != HAPTIC_OK)
      return false;
    const Reply<haptic_object_state> found(state);
    return found->id == id_;
  }

  std::weak_ptr<haptic_client> client_;
  std::string name_;
  std::uint32_t id_;
  std::uint64_t epoch_;
  bool removes_ = true;
};

/** The daemon's scene, seen through a client. */
class Scene {
 public:
  explicit Scene(std::weak_ptr<haptic_client> client) noexcept : client_(std::move(client)) {}

  Result<Object> create(const haptic_object& object) {
    std::uint32_t id = 0;
    const std::uint64_t epoch = detail::epochOf(client_.lock().get());
    auto done = detail::run([&](auto* e) { return haptic_object_create(client_.lock().get(), &object, &id, e); });
    if (!done) return done.error();
    return Object(client_, object.name, id, epoch);
  }
  Result<void> remove(const std::string& name) {
    return detail::run([&](auto* e) { return haptic_object_remove(client_.lock().get(), name.c_str(), e); });
  }
  [[nodiscard]] Result<Reply<haptic_object_list>> list() const {
    return detail::ask<haptic_object_list>(
        [&](auto** out, auto* e) { return haptic_object_list_all(client_.lock().get(), out, e); });
  }
  [[nodiscard]] Result<Reply<haptic_object_state>> find(const std::string& name) const {
    return detail::ask<haptic_object_state>(
        [&](auto** out, auto* e) { return haptic_object_find(client_.lock().get(), name.c_str(), out, e); });
  }

  Result<Upload> beginUpload(std::uint32_t vertices, std::uint32_t triangles, std::uint32_t flags = 0) {
    haptic_upload* handle = nullptr;
    auto done = detail::run(
        [&](auto* e) { return haptic_upload_begin(client_.lock().get(), vertices, triangles, flags, &handle, e); });
    if (!done) return done.error();
    return Upload(handle, vertices, triangles);
  }
  /** Uploads and builds a mesh: x, y, z per vertex and three indices per triangle. */
  Result<Reply<haptic_mesh_report>> upload(std::span<const float> vertices, std::span<const std::uint32_t> triangles,
                                           std::uint32_t flags = 0, const Progress& progress = {}) {
    if (vertices.size() % 3 != 0) return left("vertices", "x, y, z");
    if (triangles.size() % 3 != 0) return left("triangles", "three indices");
    return detail::ask<haptic_mesh_report>([&](auto** out, auto* e) {
      return haptic_upload_mesh(client_.lock().get(), vertices.data(), static_cast<std::uint32_t>(vertices.size() / 3),
                                triangles.data(), static_cast<std::uint32_t>(triangles.size() / 3), flags,
                                progress ? detail::callProgress : nullptr, const_cast<Progress*>(&progress), out, e);
    });
  }
  [[nodiscard]] Result<Reply<haptic_mesh_list>> meshes() const {
    return detail::ask<haptic_mesh_list>(
        [&](auto** out, auto* e) { return haptic_mesh_list_all(client_.lock().get(), out, e); });
  }
  /** The volume of an object's mesh as an OpenVDB file, to be read. Codes as of haptic_object_volume_file(). */
  [[nodiscard]] Result<Descriptor> volumeFile(const std::string& name) const {
    int fd = -1;
    auto done =
        detail::run([&](auto* e) { return haptic_object_volume_file(client_.lock().get(), name.c_str(), &fd, e); });
    if (!done) return done.error();
    return Descriptor(fd);
  }
  Result<void> dropMesh(std::uint64_t mesh) {
    return detail::run([&](auto* e) { return haptic_mesh_drop(client_.lock().get(), mesh, e); });
  }

  /** A grey picture, row by row from its upper edge: 65535 is the surface itself, 0 the deepest. */
  Result<Reply<haptic_texture_report>> uploadRelief(std::span<const std::uint16_t> grey, std::uint32_t width) {
    if (width != 0 && grey.size() % width != 0) return left("grey", "a whole row");
    const auto height = width == 0 ? 0 : static_cast<std::uint32_t>(grey.size() / width);
    return detail::ask<haptic_texture_report>([&](auto** out, auto* e) {
      return haptic_upload_relief(client_.lock().get(), grey.data(), width, height, out, e);
    });
  }
  Result<Reply<haptic_texture_report>> uploadVibration(const haptic_vibration& vibration) {
    return detail::ask<haptic_texture_report>(
        [&](auto** out, auto* e) { return haptic_upload_vibration(client_.lock().get(), &vibration, out, e); });
  }
  [[nodiscard]] Result<Reply<haptic_texture_list>> textures() const {
    return detail::ask<haptic_texture_list>(
        [&](auto** out, auto* e) { return haptic_texture_list_all(client_.lock().get(), out, e); });
  }
  Result<void> dropTexture(std::uint64_t texture) {
    return detail::run([&](auto* e) { return haptic_texture_drop(client_.lock().get(), texture, e); });
  }

 private:
  static Error left(const char* where, const char* each) {
    Error error{HAPTIC_INVALID_ARGUMENT, where, "numbers are left over, each has ", {}};
    error.what += each;
    return error;
  }

  std::weak_ptr<haptic_client> client_;
};

}  // namespace haptic
