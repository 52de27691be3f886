// The schema is a promise to programs already compiled: ordinals and types are spelled out here by hand.
#include <capnp/message.h>
#include <capnp/schema.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "daemon/event/event.h"
#include "proto/control.capnp.h"
#include "rt/scene/scene.h"

namespace hapticd::test {
namespace {

template <class Interface>
std::string methods() {
  std::string all;
  for (const auto method : capnp::Schema::from<Interface>().getMethods()) {
    EXPECT_EQ(method.getOrdinal(), method.getIndex());
    all += (all.empty() ? "" : " ") + std::string(method.getProto().getName().cStr());
  }
  return all;
}

template <class Struct>
std::string fields() {
  std::string all;
  const auto list = capnp::Schema::from<Struct>().getFields();
  for (unsigned i = 0; i < list.size(); ++i) {
    EXPECT_EQ(list[i].getProto().getOrdinal().getExplicit(), i);
    all += (all.empty() ? "" : " ") + std::string(list[i].getProto().getName().cStr());
  }
  return all;
}

/** `promised` is what stands first, in this order; later fields may follow. */
void startsWith(const std::string& have, const std::string& promised) {
  EXPECT_EQ(have.substr(0, promised.size()), promised);
}

TEST(Schema, MethodsKeepTheirNumbers) {
  startsWith(
      methods<proto::Daemon>(),
      "hello listDevices openDevice closeDevice openSession scene get set state statistics subscribe stop setLimits "
      "configuration doctor dump");
  startsWith(methods<proto::Session>(), "regions mapped acquireLease releaseLease arm disarm");
  startsWith(methods<proto::Scene>(),
             "create remove list find setPose setMaterial setFlags setShape beginUpload dropMesh listMeshes "
             "setSurface dropTexture listTextures volumeFile");
  startsWith(methods<proto::Upload>(), "region commit");
  startsWith(methods<proto::EventListener>(), "events");
}

TEST(Schema, FieldsKeepTheirNumbers) {
  startsWith(fields<proto::Status>(), "code where what remedy");
  startsWith(fields<proto::Limits>(), "force torque forceSlew torqueSlew velocity power activePower gripperForce");
  startsWith(fields<proto::SessionInfo>(),
             "id epoch device deviceIndex deviceCount periodNs regionABytes regionBBytes");
  startsWith(fields<proto::ObjectSpec>(), "name parent pose shape material enabled visible twoSided keep");
  startsWith(fields<proto::Material>(), "stiffness damping frictionStatic frictionDynamic");
  startsWith(fields<proto::Event>(), "kind tNs tick device object session value point force text");
  startsWith(fields<proto::DaemonInfo>(),
             "version protocolMajor protocolMinor epoch pid administration realtime schedulingNote socket configFile "
             "startedNs");
}

TEST(Schema, IdsAndDefaultsStay) {
  EXPECT_EQ(capnp::Schema::from<proto::Daemon>().getProto().getScopeId(), 0xb6f3c2a9d1e84715u);
  capnp::MallocMessageBuilder message;
  const auto object = message.initRoot<proto::ObjectSpec>();
  EXPECT_EQ(object.asReader().getPose().getQ().getW(), 1.0);
  EXPECT_TRUE(object.asReader().getEnabled());
  EXPECT_TRUE(object.asReader().getVisible());
  EXPECT_FALSE(object.asReader().getKeep());
  EXPECT_EQ(proto::PROTOCOL_MAJOR, 1);
}

TEST(Schema, EnumerantsAreTheDaemonsNumbers) {
  const std::map<std::string, EventKind> ours = {
      {"touch", EventKind::kTouch},
      {"untouch", EventKind::kUntouch},
      {"button", EventKind::kButton},
      {"fault", EventKind::kFault},
      {"armed", EventKind::kArmed},
      {"disarmed", EventKind::kDisarmed},
      {"leaseLost", EventKind::kLeaseLost},
      {"leaseTaken", EventKind::kLeaseTaken},
      {"deviceAdded", EventKind::kDeviceAdded},
      {"deviceRemoved", EventKind::kDeviceRemoved},
      {"overrun", EventKind::kOverrun},
      {"clientJoined", EventKind::kClientJoined},
      {"clientLeft", EventKind::kClientLeft},
      {"modelExpired", EventKind::kModelExpired},
      {"objectChanged", EventKind::kObjectChanged},
      {"refused", EventKind::kRefused},
  };
  const auto kinds = capnp::Schema::from<proto::EventKind>().getEnumerants();
  ASSERT_EQ(kinds.size(), kEventKinds);
  ASSERT_EQ(ours.size(), kEventKinds);
  for (const auto kind : kinds) {
    const std::string name = kind.getProto().getName().cStr();
    EXPECT_EQ(ours.at(name), static_cast<EventKind>(kind.getOrdinal())) << name;
  }
  EXPECT_EQ(static_cast<unsigned>(proto::ShapeKind::GROUP), static_cast<unsigned>(ShapeKind::kGroup));
  EXPECT_EQ(static_cast<unsigned>(proto::ShapeKind::PLANE), static_cast<unsigned>(ShapeKind::kPlane));
  EXPECT_EQ(static_cast<unsigned>(proto::ShapeKind::SPHERE), static_cast<unsigned>(ShapeKind::kSphere));
  EXPECT_EQ(static_cast<unsigned>(proto::ShapeKind::BOX), static_cast<unsigned>(ShapeKind::kBox));
  EXPECT_EQ(static_cast<unsigned>(proto::ShapeKind::CAPSULE), static_cast<unsigned>(ShapeKind::kCapsule));
  EXPECT_EQ(static_cast<unsigned>(proto::ShapeKind::CYLINDER), static_cast<unsigned>(ShapeKind::kCylinder));
  EXPECT_EQ(static_cast<unsigned>(proto::ShapeKind::MESH), static_cast<unsigned>(ShapeKind::kMesh));
}

}  // namespace
}  // namespace hapticd::test
