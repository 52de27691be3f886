/** @file
 * Between the daemon's values and the schema's. Reading checks texts; numbers are checked by who uses them.
 */
#pragma once

#include <string>

#include "daemon/control/core.h"
#include "proto/control.capnp.h"

namespace hapticd {

/** The text itself: it must outlive what is made of it. */
[[nodiscard]] capnp::Text::Reader text(const std::string& in);
void setStatus(proto::Status::Builder out, const Result<void>& result);

/** kInvalidArgument if longer than `most` bytes, not UTF-8, or with control characters. */
[[nodiscard]] Result<void> checkText(capnp::Text::Reader in, std::size_t most, const char* where);
/** The same, and the text. */
[[nodiscard]] Result<std::string> readText(capnp::Text::Reader in, std::size_t most, const char* where);
inline constexpr std::size_t kMostName = 63;    ///< Bytes of an object's name.
inline constexpr std::size_t kMostClient = 64;  ///< Of a client's: to so many its library cuts that of a program.
inline constexpr std::size_t kMostUri = 1024;   ///< Bytes of a device URI.

[[nodiscard]] Vec3 read(proto::Vec3::Reader in);
[[nodiscard]] Pose read(proto::Pose::Reader in);
[[nodiscard]] hd_material read(proto::Material::Reader in);
[[nodiscard]] SurfaceSpec read(proto::Surface::Reader in);
[[nodiscard]] ShapeSpec read(proto::Shape::Reader in);
[[nodiscard]] GuardLimits read(proto::Limits::Reader in);
/** An absent pose is the identity, an absent material the default one. */
[[nodiscard]] Result<ObjectSpec> read(proto::ObjectSpec::Reader in);

void write(proto::Vec3::Builder out, const Vec3& in);
void write(proto::Vec3::Builder out, const double (&in)[3]);
void write(proto::Pose::Builder out, const Pose& in);
void write(proto::Material::Builder out, const hd_material& in);
void write(proto::Surface::Builder out, const SurfaceSpec& in);
void write(proto::TextureReport::Builder out, const TextureInfo& in);
void write(proto::Limits::Builder out, const GuardLimits& in);
/** Everything but `name`, `open`, calibration and temperature. */
void write(proto::DeviceInfo::Builder out, const DeviceInfo& in);
void write(proto::DeviceInfo::Builder out, const OpenDevice& in);
void write(proto::ObjectState::Builder out, const ObjectNow& in);
void write(proto::MeshReport::Builder out, const MeshInfo& in);
void write(proto::Event::Builder out, const Event& in);

}  // namespace hapticd
