// texture.h: what surfaces feel like, and the textures that the daemon has.
#include <cstddef>

#include "libclient/src/api/call.h"
#include "libclient/src/reply/convert.h"

using hapticd::client::Failure;
using hapticd::client::Link;
using hapticd::client::Reply;
namespace client = hapticd::client;

extern "C" {

int haptic_object_set_surface(haptic_client* c, const char* name, const haptic_surface* surface, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (name == nullptr) return client::badArgument("name", "is null");
    haptic_surface full = HAPTIC_SURFACE_INIT;
    if (Failure bad = client::readSized(surface, full, offsetof(haptic_surface, transient_gain), "haptic_surface"))
      return bad;
    if (Failure bad = client::checkReserved(full.reserved, "haptic_surface.reserved")) return bad;
    return client::callDaemon(*c->connection, [&](Link& link) {
      auto request = link.scene.setSurfaceRequest();
      request.setName(name);
      client::fill(full, request.initSurface());
      return request;
    });
  });
}

int haptic_texture_list_all(haptic_client* c, haptic_texture_list** textures, haptic_error* error) {
  return client::query(
      c, textures, error, [](Link& link) { return link.scene.listTexturesRequest(); },
      [](auto& results, Reply& memory) { return client::convert(results.getTextures(), memory); });
}

int haptic_texture_drop(haptic_client* c, uint64_t texture, haptic_error* error) {
  return client::order(c, error, [&](Link& link) {
    auto request = link.scene.dropTextureRequest();
    request.setTexture(texture);
    return request;
  });
}

}  // extern "C"
