// texture.h: reliefs and vibrations on their way.
#include <cstring>

#include "libclient/src/connection/loop.h"
#include "libclient/src/reply/convert.h"
#include "libclient/src/upload/upload_region.h"
#include "proto/texture.h"

using hapticd::client::Connection;
using hapticd::client::Failure;
using hapticd::client::Link;
using hapticd::client::Mapping;
using hapticd::client::Reply;
namespace client = hapticd::client;
namespace proto = hapticd::proto;

namespace {

/** Writes one after the other. */
class Writer {
 public:
  explicit Writer(void* to) : to_(static_cast<std::byte*>(to)) {}
  template <class T>
  void put(const T* from, std::size_t count) {
    std::memcpy(to_, from, count * sizeof(T));
    to_ += count * sizeof(T);
  }
  template <class T>
  void put(const T& value) {
    put(&value, 1);
  }

 private:
  std::byte* to_;
};

/** Has `write` fill `bytes` of the daemon's memory and the daemon take them for a texture. */
template <class Write>
Failure upload(haptic_client* c, std::size_t bytes, haptic_texture_report** report, Write&& write) {
  if (c == nullptr) return client::badArgument("client", "is null");
  Connection& connection = *c->connection;
  proto::Upload::Client capability = nullptr;
  Reply memory;
  haptic_texture_report* made = nullptr;
  const auto fillAndCommit = [&]() -> Failure {
    Mapping mapping;
    if (Failure failure = client::openUpload(connection, bytes, capability, mapping)) return failure;
    write(Writer(mapping.address()));
    mapping.unmap();
    return client::commitPatiently([&] {
      return client::callDaemon(
          connection, [&](Link&) { return capability.commitTextureRequest(); },
          [&](auto& results) { made = client::convert(results.getTexture(), memory); });
    });
  };
  Failure failure = fillAndCommit();
  connection.run([&](Connection::Loop&) { capability = nullptr; });
  if (failure) return failure;
  if (report != nullptr) *report = memory.release(made);
  return {};
}

Failure check(const haptic_vibration& v) {
  const auto count = [](std::uint32_t value, std::uint32_t least, std::uint32_t most, const char* name) -> Failure {
    if (value >= least && value <= most) return {};
    return client::badArgument(std::string("haptic_vibration.") + name, "is " + std::to_string(value),
                               "give " + std::to_string(least) + " to " + std::to_string(most));
  };
  if (Failure bad = count(v.order, 1, HD_VIBRATION_MOST_ORDER, "order")) return bad;
  if (Failure bad = count(v.model_count, 3, HD_VIBRATION_MOST_MODELS, "model_count")) return bad;
  if (Failure bad = count(v.triangle_count, 1, HD_VIBRATION_MOST_TRIANGLES, "triangle_count")) return bad;
  if (v.models == nullptr) return client::badArgument("haptic_vibration.models", "is null");
  if (v.triangles == nullptr) return client::badArgument("haptic_vibration.triangles", "is null");
  for (std::uint32_t i = 0; i < v.model_count; ++i) {
    if (v.models[i].a == nullptr)
      return client::badArgument("haptic_vibration.models[" + std::to_string(i) + "].a", "is null");
  }
  return {};
}

}  // namespace

extern "C" {

int haptic_upload_relief(haptic_client* c, const uint16_t* grey, uint32_t width, uint32_t height,
                         haptic_texture_report** report, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (grey == nullptr) return client::badArgument("grey", "is null");
    for (const auto& [name, side] : {std::pair{"width", width}, std::pair{"height", height}}) {
      if (side < HD_RELIEF_LEAST_SIDE || side > HD_RELIEF_MOST_SIDE) {
        return client::badArgument(
            name, "is " + std::to_string(side),
            "give " + std::to_string(HD_RELIEF_LEAST_SIDE) + " to " + std::to_string(HD_RELIEF_MOST_SIDE));
      }
    }
    const std::size_t pixels = std::size_t{width} * height;
    return upload(c, sizeof(hd_relief_upload) + 2 * pixels, report, [&](Writer to) {
      to.put(hd_relief_upload{{HD_TEXTURE_MAGIC, HD_TEXTURE_RELIEF, 0}, width, height});
      to.put(grey, pixels);
    });
  });
}

int haptic_upload_vibration(haptic_client* c, const haptic_vibration* vibration, haptic_texture_report** report,
                            haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    haptic_vibration v{};
    if (Failure bad = client::readSized(vibration, v, sizeof(haptic_vibration), "haptic_vibration")) return bad;
    if (Failure bad = check(v)) return bad;
    const std::size_t corners = std::size_t{3} * v.triangle_count;
    const std::size_t bytes = sizeof(hd_vibration_upload) +
                              v.model_count * (sizeof(hd_vibration_model) + v.order * sizeof(double)) +
                              corners * sizeof(std::uint32_t);
    return upload(c, bytes, report, [&](Writer to) {
      to.put(hd_vibration_upload{
          {HD_TEXTURE_MAGIC, HD_TEXTURE_VIBRATION, 0}, v.model_count, v.triangle_count, v.order, 0, v.rate_hz});
      for (std::uint32_t i = 0; i < v.model_count; ++i) {
        const haptic_vibration_model& model = v.models[i];
        to.put(hd_vibration_model{model.speed, model.force, model.variance});
        to.put(model.a, v.order);
      }
      to.put(v.triangles, corners);
    });
  });
}

}  // extern "C"
