// scene.h: objects.
#include "libclient/src/api/call.h"
#include "libclient/src/connection/descriptor.h"
#include "libclient/src/reply/convert.h"

using hapticd::client::Failure;
using hapticd::client::Link;
using hapticd::client::Reply;
namespace client = hapticd::client;

namespace {

constexpr std::uint32_t kFlags =
    HAPTIC_OBJECT_ENABLED | HAPTIC_OBJECT_VISIBLE | HAPTIC_OBJECT_TWO_SIDED | HAPTIC_OBJECT_KEEP;

/** A change of a named object that is answered by a status alone. */
template <class Make>
int change(haptic_client* c, const char* name, const void* value, haptic_error* error, Make&& make) {
  if (name == nullptr) return client::refuse(error, "name", "is null");
  if (value == nullptr) return client::refuse(error, "value", "is null");
  return client::order(c, error, [&](Link& link) {
    auto request = make(link.scene);
    request.setName(name);
    return request;
  });
}

Failure checkShape(const haptic_shape& shape) {
  if (shape.kind <= HAPTIC_SHAPE_MESH) return client::checkReserved(shape.reserved, "haptic_shape.reserved");
  return client::badArgument("shape.kind", "is " + std::to_string(shape.kind), "use a haptic_shape_kind");
}

}  // namespace

extern "C" {

int haptic_object_create(haptic_client* c, const haptic_object* object, uint32_t* id, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    haptic_object full = HAPTIC_OBJECT_INIT;
    if (Failure bad = client::readSized(object, full, offsetof(haptic_object, material), "haptic_object")) return bad;
    if (full.name == nullptr) return client::badArgument("haptic_object.name", "is null");
    if ((full.flags & ~kFlags) != 0) return client::badArgument("haptic_object.flags", "has bits that are not defined");
    if (Failure bad = checkShape(full.shape)) return bad;
    const auto make = [&](Link& link) {
      auto request = link.scene.createRequest();
      client::fill(full, request.initObject());
      return request;
    };
    return client::callDaemon(*c->connection, make, [&](auto& results) {
      if (id != nullptr) *id = results.getId();
    });
  });
}

int haptic_object_remove(haptic_client* c, const char* name, haptic_error* error) {
  return change(c, name, name, error, [](auto& scene) { return scene.removeRequest(); });
}

int haptic_object_volume_file(haptic_client* c, const char* name, int* fd, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (name == nullptr) return client::badArgument("name", "is null");
    if (fd == nullptr) return client::badArgument("fd", "is null");
    int received = -1;
    Failure refusal;
    Failure broken = c->connection->call([&](Link& link) -> kj::Promise<void> {
      auto request = link.scene.volumeFileRequest();
      request.setName(name);
      refusal = client::tooLong(request.totalSize().wordCount);
      if (refusal) return kj::READY_NOW;
      return request.send().then([&](auto&& results) -> kj::Promise<void> {
        refusal = client::toFailure(results.getStatus());
        if (refusal) return kj::READY_NOW;
        return client::keepDescriptor(results.getFile(), "file", received, refusal);
      });
    });
    if (broken) return broken;
    if (refusal) return refusal;
    *fd = received;
    return {};
  });
}

int haptic_object_list_all(haptic_client* c, haptic_object_list** objects, haptic_error* error) {
  return client::query(
      c, objects, error, [](Link& link) { return link.scene.listRequest(); },
      [](auto& results, Reply& memory) { return client::convert(results.getObjects(), memory); });
}

int haptic_mesh_list_all(haptic_client* c, haptic_mesh_list** meshes, haptic_error* error) {
  return client::query(
      c, meshes, error, [](Link& link) { return link.scene.listMeshesRequest(); },
      [](auto& results, Reply& memory) { return client::convert(results.getMeshes(), memory); });
}

int haptic_object_find(haptic_client* c, const char* name, haptic_object_state** state, haptic_error* error) {
  if (name == nullptr) return client::refuse(error, "name", "is null");
  return client::query(
      c, state, error,
      [&](Link& link) {
        auto request = link.scene.findRequest();
        request.setName(name);
        return request;
      },
      [](auto& results, Reply& memory) { return client::convert(results.getObject(), memory); });
}

int haptic_object_set_pose(haptic_client* c, const char* name, const haptic_pose* pose, haptic_error* error) {
  return change(c, name, pose, error, [&](auto& scene) {
    auto request = scene.setPoseRequest();
    client::fill(*pose, request.initPose());
    return request;
  });
}

int haptic_object_set_material(haptic_client* c, const char* name, const haptic_material* material,
                               haptic_error* error) {
  return change(c, name, material, error, [&](auto& scene) {
    auto request = scene.setMaterialRequest();
    client::fill(*material, request.initMaterial());
    return request;
  });
}

int haptic_object_set_flags(haptic_client* c, const char* name, uint32_t flags, haptic_error* error) {
  if ((flags & ~kFlags) != 0) return client::refuse(error, "flags", "has bits that are not defined");
  return change(c, name, name, error, [&](auto& scene) {
    auto request = scene.setFlagsRequest();
    request.setEnabled((flags & HAPTIC_OBJECT_ENABLED) != 0);
    request.setVisible((flags & HAPTIC_OBJECT_VISIBLE) != 0);
    request.setTwoSided((flags & HAPTIC_OBJECT_TWO_SIDED) != 0);
    return request;
  });
}

int haptic_object_set_shape(haptic_client* c, const char* name, const haptic_shape* shape, haptic_error* error) {
  if (shape != nullptr) {
    if (const int bad = client::edge(error, [&] { return checkShape(*shape); })) return bad;
  }
  return change(c, name, shape, error, [&](auto& scene) {
    auto request = scene.setShapeRequest();
    client::fill(*shape, request.initShape());
    return request;
  });
}

int haptic_mesh_drop(haptic_client* c, uint64_t mesh, haptic_error* error) {
  return client::order(c, error, [&](Link& link) {
    auto request = link.scene.dropMeshRequest();
    request.setMesh(mesh);
    return request;
  });
}

}  // extern "C"
