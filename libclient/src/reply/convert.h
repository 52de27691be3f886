/** @file
 * Between the control schema and the structures of the C interface: convert() makes results within a Reply, fill()
 * writes requests.
 */
#pragma once

#include <hapticclient/hapticclient.h>

#include "libclient/src/connection/connection.h"
#include "libclient/src/reply/reply.h"

namespace hapticd::client {

haptic_device_info* convert(proto::DeviceInfo::Reader from, Reply& reply);
haptic_daemon_info* convert(const Connection::Info& from, Reply& reply);
haptic_object_state* convert(proto::ObjectState::Reader from, Reply& reply);
haptic_status* convert(proto::DaemonState::Reader from, const Connection::Info& info, Reply& reply);
haptic_statistics* convert(proto::Statistics::Reader from, Reply& reply);
haptic_mesh_report* convert(proto::MeshReport::Reader from, Reply& reply);
haptic_surface* convert(proto::Surface::Reader from, Reply& reply);
haptic_texture_report* convert(proto::TextureReport::Reader from, Reply& reply);
haptic_texture_list* convert(capnp::List<proto::TextureReport>::Reader from, Reply& reply);
haptic_check_list* convert(capnp::List<proto::Check>::Reader from, Reply& reply);
haptic_device_list* convert(capnp::List<proto::DeviceInfo>::Reader from, Reply& reply);
haptic_mesh_list* convert(capnp::List<proto::MeshReport>::Reader from, Reply& reply);
haptic_object_list* convert(capnp::List<proto::ObjectState>::Reader from, Reply& reply);
haptic_device_limits convert(proto::Limits::Reader from);

void fill(const haptic_device_limits& from, proto::Limits::Builder to);
void fill(const haptic_pose& from, proto::Pose::Builder to);
void fill(const haptic_material& from, proto::Material::Builder to);
void fill(const haptic_surface& from, proto::Surface::Builder to);
void fill(const haptic_shape& from, proto::Shape::Builder to);
void fill(const haptic_object& from, proto::ObjectSpec::Builder to);

inline void convert(proto::Vec3::Reader from, double (&to)[3]) {
  to[0] = from.getX();
  to[1] = from.getY();
  to[2] = from.getZ();
}

}  // namespace hapticd::client
