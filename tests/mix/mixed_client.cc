#include "tests/mix/mixed_client.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>

namespace hapticd::test {
namespace {

using std::chrono::milliseconds;

constexpr const char* kUris[] = {"",
                                 "sim",
                                 "sim2",
                                 "sim3",
                                 "sim://falcon",
                                 "sim://touch?motion=tap",
                                 "sim://sigma7?motion=minjerk&seed=3",
                                 "sim://default?dof=6&motion=circle",
                                 "sim://default?motion=csv&file=/etc/passwd",
                                 "replay:///nowhere.csv",
                                 "what://ever"};
constexpr const char* kNames[] = {"a", "b", "c", "d", "e", "f", "g", "not a name", ""};

struct Points {
  std::vector<float> vertices;
  std::vector<std::uint32_t> triangles;
};

/** A ball of 20 mm. */
Points ball(std::uint32_t rings) {
  Points points;
  const std::uint32_t around = 2 * rings;
  for (std::uint32_t i = 0; i <= rings; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const double polar = std::numbers::pi * i / rings, turn = 2 * std::numbers::pi * j / around;
      for (const double x : {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)})
        points.vertices.push_back(static_cast<float>(0.02 * x));
    }
  }
  for (std::uint32_t i = 0; i < rings; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t next = (j + 1) % around;
      const std::uint32_t a = i * around + j, b = i * around + next, c = a + around, d = b + around;
      for (const std::uint32_t corner : {a, c, d, a, d, b}) points.triangles.push_back(corner);
    }
  }
  return points;
}

}  // namespace

template <class T>
bool MixedClient::note(const haptic::Result<T>& result) {
  if (result.code() == HAPTIC_INTERNAL) defect_ = result.error().message();
  return result.ok();
}

std::string MixedClient::name() { return any(kNames); }
std::string MixedClient::uri() { return any(kUris); }

haptic::Session* MixedClient::session() {
  return sessions_.empty() ? nullptr : &sessions_[random_.below(sessions_.size())];
}

std::uint32_t MixedClient::objectId() {
  return ids_.empty() || random_.once(10) ? random_.below(300u) : ids_[random_.below(ids_.size())];
}

haptic_shape MixedClient::shape() {
  haptic_shape shape{
      random_.below(8u), 0, {}, meshes_.empty() ? random_.below(9u) : meshes_[random_.below(meshes_.size())]};
  for (double& size : shape.size) size = random_.once(30) ? random_.wild() : random_.in(0.002, 0.05);
  return shape;
}

haptic_pose MixedClient::pose() {
  const Pose X = random_.pose(random_.once(20) ? 50 : 0.05);
  return {{X.p.x(), X.p.y(), X.p.z()}, {X.q.w(), X.q.x(), X.q.y(), X.q.z()}};
}

haptic_material MixedClient::material() {
  const double friction = random_.in(0, 1);
  return {random_.once(30) ? random_.wild() : random_.in(0, 3000), random_.in(0, 5), friction,
          friction * random_.in(0, 1)};
}

void MixedClient::devices() {
  switch (random_.below(6)) {
    case 0:
      return (void)note(client_.closeDevice(uri()));
    case 1:
      return (void)note(client_.devices());
    case 2:
      return (void)note(client_.stop(random_.once(2) ? "" : uri()));
    default:
      return (void)note(client_.openDevice(uri()));
  }
}

void MixedClient::sessions() {
  if (!sessions_.empty() && random_.once(3)) {
    sessions_.erase(sessions_.begin() + static_cast<std::ptrdiff_t>(random_.below(sessions_.size())));
    return;
  }
  if (sessions_.size() >= 4) return;
  auto opened = client_.openSession(uri(), name());
  if (note(opened)) sessions_.push_back(std::move(*opened));
}

void MixedClient::arm() {
  haptic::Session* const with = session();
  if (with == nullptr) return sessions();
  switch (random_.below(5)) {
    case 0:
      return (void)note(with->disarm());
    case 1:
      return (void)note(with->releaseLease());
    case 2:
      return (void)note(with->acquireLease());
    default:
      return (void)note(with->arm());
  }
}

void MixedClient::push() {
  haptic::Session* const to = session();
  if (to == nullptr) return sessions();
  const auto doubles = [&](auto& numbers, double size) {
    for (double& x : numbers) x = random_.once(200) ? random_.wild() : random_.in(-size, size);
  };
  for (int i = random_.below(60); i >= 0; --i) {
    const haptic::PushOptions how{.latest = random_.once(4),
                                  .at_tick = random_.once(6) ? random_.below(std::uint64_t{20'000}) : 0};
    const std::int64_t lease_ns = random_.below(std::int64_t{10'100'000'000}), blend_ns = random_.below(1'100'000'000);
    switch (random_.below(10)) {
      case 0: {
        haptic_local_model model = HAPTIC_LOCAL_MODEL_INIT;
        model.slot = random_.below(9u);
        model.kind = random_.below(7u);
        model.frame = random_.once(3) ? objectId() : 0;
        model.device = random_.below(3u);
        model.lease_ns = lease_ns;
        model.blend_ns = blend_ns;
        model.material = material();
        doubles(model.origin, 0.05);
        model.normal[random_.below(3)] = 1;
        model.radius = random_.in(-0.05, 0.05);
        model.count = random_.below(18u);
        for (auto& half : model.halfspace) half[random_.below(4)] = 1;
        (void)note(to->push(model, how));
        break;
      }
      case 1: {
        haptic_force_field field = HAPTIC_FORCE_FIELD_INIT;
        field.slot = random_.below(9u);
        field.frame = random_.once(3) ? objectId() : 0;
        field.lease_ns = lease_ns;
        field.blend_ns = blend_ns;
        doubles(field.x0, 0.05);
        doubles(field.f0, 5);
        doubles(field.jacobian, 500);
        field.radius = random_.in(0, 0.2);
        (void)note(to->push(field, how));
        break;
      }
      case 2:
        (void)note(to->push(haptic_clear_model{random_.below(9u), 0, blend_ns}, how));
        break;
      case 3: {
        haptic_client_force force = HAPTIC_CLIENT_FORCE_INIT;
        force.device = random_.below(3u);
        force.lease_ns = lease_ns;
        doubles(force.force, 8);
        doubles(force.torque, 0.3);
        (void)note(to->push(force, how));
        break;
      }
      case 4: {
        haptic_intent intent = HAPTIC_INTENT_INIT;
        intent.device = random_.below(3u);
        doubles(intent.p, 0.05);
        (void)note(to->push(intent, how));
        break;
      }
      case 5:
        (void)note(to->push(haptic_session_limits{random_.in(0, 12), random_.in(0, 1)}, how));
        break;
      case 6: {
        haptic_object_vertices moves{objectId(), random_.below(28u), {}};
        for (haptic_vertex_move& move : moves.move) {
          move.index = random_.below(80u);
          for (float& x : move.p) x = static_cast<float>(random_.in(-0.03, 0.03));
        }
        (void)note(to->push(moves, how));
        break;
      }
      case 7:
        (void)note(to->push(haptic_object_material{objectId(), 0, material()}, how));
        break;
      case 8:
        (void)note(to->push(haptic_object_flags{objectId(), random_.below(9u), random_.below(9u), 0}, how));
        break;
      default: {
        haptic_object_pose moved = HAPTIC_OBJECT_POSE_INIT;
        moved.object = objectId();
        doubles(moved.p, 0.05);
        doubles(moved.v, 0.1);
        doubles(moved.w, 3);
        (void)note(to->push(moved, how));
      }
    }
  }
}

void MixedClient::read() {
  haptic::Session* const of = session();
  if (of == nullptr) return sessions();
  std::vector<haptic_sample> room(random_.below(std::size_t{300}));
  std::uint64_t lost = 0;
  (void)note(of->drain(room, lost));
  (void)note(of->latest());
  (void)note(of->acks());
  (void)note(of->counters());
  (void)note(of->model(random_.below(10u)));
  (void)note(of->describe());
}

void MixedClient::create() {
  haptic_object object = HAPTIC_OBJECT_INIT;
  const std::string own = name(), parent = random_.once(3) ? name() : "";
  object.name = own.c_str();
  object.parent = parent.c_str();
  object.pose = pose();
  object.shape = shape();
  object.material = material();
  if (random_.once(8)) object.flags |= HAPTIC_OBJECT_KEEP;
  auto made = client_.scene().create(object);
  if (!note(made)) return;
  ids_.push_back(made->id());
  if (random_.once(4)) return;  // Removed at once.
  if (random_.once(3)) {
    haptic_surface surface = HAPTIC_SURFACE_INIT;
    surface.smooth_deg = random_.in(0, 60);
    surface.transient_gain = random_.in(0, 5);
    if (!textures_.empty()) surface.relief = textures_[random_.below(textures_.size())];
    if (!textures_.empty()) surface.vibration = textures_[random_.below(textures_.size())];
    (void)note(made->setSurface(surface));
  }
  if (random_.once(3)) {
    haptic_effect effect = HAPTIC_EFFECT_INIT;
    effect.kind = random_.below(7u);
    effect.duration_s = random_.once(2) ? random_.in(0, 0.5) : 0;
    std::vector<std::array<double, 3>> path(random_.below(std::size_t{6}));
    for (auto& point : path) point = {random_.in(-0.05, 0.05), random_.in(-0.05, 0.05), random_.in(-0.05, 0.05)};
    (void)note(made->setEffect(effect, path));
  }
  if (random_.once(3)) (void)note(made->setShape(shape()));
  if (random_.once(3)) (void)note(made->setMaterial(material()));
  if (random_.once(3)) (void)note(made->setPose(pose()));
  if (random_.once(3)) (void)note(made->setFlags(random_.below(8u)));
  made->release();
}

void MixedClient::change() {
  if (random_.once(4)) return (void)note(client_.scene().remove(name()));
  static constexpr const char* kChanges[] = {"pos?value=0,0,0.01",     "worldpos?value=0.01,0,0",
                                             "velocity?value=0,0,0.2", "mass?value=0.2",
                                             "mass?value=0",           "falls?value=true",
                                             "motion_damping?value=3", "effect?value=guide,force=2",
                                             "effect?value=none",      "effect_path?value=0,0,0,0.01,0,0,0.02,0.01,0",
                                             "enabled?value=false",    "enabled?value=true",
                                             "stiffness?value=900",    "smooth_deg?value=30",
                                             "relief?value=1",         "relief?value=0",
                                             "vibration?value=2",      "twosided?value=true",
                                             "rot?value=0.6,0.8,0,0",  "stiffness?value=nan",
                                             "nothing?value=1",        "mass?value=-1e300",
                                             "pos?value=1,2"};
  (void)note(client_.set(fmt::format("/objects/{}/{}", name(), any(kChanges))));
}

void MixedClient::look() {
  static constexpr const char* kPaths[] = {
      "/",       "/objects",  "/_objects", "/devices",          "/statistics", "/clients", "/world",
      "/meshes", "/textures", "/volumes",  "/devices/sim/tool", "/objects/a",  "/no"};
  switch (random_.below(9)) {
    case 0:
      return (void)note(client_.status());
    case 1:
      return (void)note(client_.dump());
    case 2:
      return (void)note(client_.doctor());
    case 3:
      return (void)note(client_.statistics(uri(), random_.once(2)));
    case 4:
      return (void)note(client_.scene().list());
    case 5:
      return (void)note(client_.configuration());
    case 6:
      return (void)note(client_.scene().volumeFile(name()));
    case 7:
      return (void)note(client_.scene().find(name()));
    default:
      return (void)note(client_.get(any(kPaths)));
  }
}

void MixedClient::mesh() {
  if (!meshes_.empty() && random_.once(5))
    return (void)note(client_.scene().dropMesh(meshes_[random_.below(meshes_.size())]));
  if (!uploads_.empty() && random_.once(3)) return uploads_.pop_back();
  constexpr std::uint32_t kRings[] = {3, 6, 12, 60};
  Points points = ball(kRings[random_.below(4)]);
  if (random_.once(5)) points.triangles.resize(points.triangles.size() / 6 * 3);  // Open.
  if (random_.once(10)) points.triangles[random_.below(points.triangles.size())] = random_.below(100'000u);
  std::uint32_t flags = random_.once(3) ? HAPTIC_MESH_DEFORMABLE : 0;
  if (random_.once(3)) flags |= HAPTIC_MESH_VOLUME | (random_.once(2) ? HAPTIC_MESH_FILL_HOLES : 0);
  auto upload = client_.scene().beginUpload(static_cast<std::uint32_t>(points.vertices.size() / 3),
                                            static_cast<std::uint32_t>(points.triangles.size() / 3), flags);
  if (!note(upload)) return;
  std::copy(points.vertices.begin(), points.vertices.end(), upload->vertices().begin());
  std::copy(points.triangles.begin(), points.triangles.end(), upload->triangles().begin());
  if ((flags & HAPTIC_MESH_VOLUME) != 0) (void)note(upload->volume(random_.in(0.001, 0.006)));
  if (random_.once(5)) {
    if (uploads_.size() < 4) uploads_.push_back(std::move(*upload));
    return;
  }
  const bool gives_up = random_.once(4);
  auto built = upload->commit([&](float, const char*) { return !gives_up || !random_.once(3); },
                              gives_up ? milliseconds(1 + random_.below(30)) : milliseconds(0));
  if (note(built)) meshes_.push_back((*built)->id);
}

void MixedClient::texture() {
  if (!textures_.empty() && random_.once(3))
    return (void)note(client_.scene().dropTexture(textures_[random_.below(textures_.size())]));
  if (random_.once(2)) {
    const std::uint32_t width = 1 + random_.below(300u), height = 1 + random_.below(300u);
    std::vector<std::uint16_t> grey(std::size_t{width} * height);
    for (std::uint16_t& pixel : grey) pixel = random_.below(std::uint16_t{65535});
    const auto made = client_.scene().uploadRelief(grey, width);
    if (note(made)) textures_.push_back((*made)->id);
    return;
  }
  const double a[] = {random_.in(-1.2, 1.2), 0.3};
  const haptic_vibration_model models[] = {{0, 0, 0.1, a}, {0.2, 0, 0.2, a}, {0, 2, 0.3, a}};
  const std::uint32_t triangle[] = {0, 1, random_.once(9) ? 7u : 2u};
  const haptic_vibration vibration{sizeof(haptic_vibration), 2, random_.in(500, 5000), 3, 1, models, triangle};
  const auto made = client_.scene().uploadVibration(vibration);
  if (note(made)) textures_.push_back((*made)->id);
}

void MixedClient::record() {
  if (recordings_.empty() || random_.once(4)) {
    auto begun = client_.record(uri());
    if (note(begun)) recordings_.push_back(std::move(*begun));
    return;
  }
  haptic::Recording& recording = recordings_.back();
  (void)fcntl(recording.fd(), F_SETFL, O_NONBLOCK);
  std::vector<char> room(1 << 20);
  for (int i = random_.below(20); i >= 0; --i) (void)!::read(recording.fd(), room.data(), room.size());
  if (random_.once(2)) return;
  if (random_.once(2)) (void)note(recording.stop());
  recordings_.pop_back();
}

void MixedClient::events() {
  if (events_.size() < 3 && random_.once(2)) {
    auto subscribed = client_.subscribe(random_.once(2) ? 0 : random_.below(1u << 16), random_.below(50u));
    if (note(subscribed)) events_.push_back(std::move(*subscribed));
  } else if (!events_.empty()) {
    for (int i = 0; i < 50 && events_.back().next(milliseconds(0)); ++i) continue;
    if (random_.once(3)) events_.pop_back();
  }
}

void MixedClient::properties() {
  static constexpr const char* kWishes[] = {"tool?value=a",
                                            "tool?value=b,0.1,500",
                                            "tool?value=c,0.2,300,weighs",
                                            "tool?value=a,direct",
                                            "tool?value=",
                                            "finger?value=soft",
                                            "finger?value=",
                                            "mount?value=0,0.1,0,0,0,90",
                                            "mount?value=",
                                            "scale?value=3",
                                            "scale?value=",
                                            "scale?value=0.5m",
                                            "clutch?value=held",
                                            "clutch?value=released",
                                            "clutch?value=1",
                                            "grip?value=0.5,0.2",
                                            "grip?value=",
                                            "radius?value=0.004",
                                            "radius?value=0",
                                            "radius?value=inf",
                                            "tool?value=a,b,c,d",
                                            "no?value=1"};
  static constexpr const char* kDevices[] = {"sim", "sim2", "sim3", "sim4", "none"};
  if (random_.once(8)) return (void)note(client_.set("/world/gravity?value=0,0,-9.81"));
  (void)note(client_.set(fmt::format("/devices/{}/{}", any(kDevices), any(kWishes))));
}

void MixedClient::limits() {
  haptic_device_limits limits{};
  limits.size = sizeof limits;
  double* const each[] = {&limits.force,    &limits.torque,       &limits.force_slew,    &limits.torque_slew,
                          &limits.velocity, &limits.active_power, &limits.gripper_force, &limits.power};
  for (double* one : each) *one = random_.once(3) ? std::nan("") : random_.in(0.1, 10);
  (void)note(client_.setLimits(uri(), limits));
}

/** When the daemon has gone; now and then also when it has not. */
void MixedClient::recover() {
  if (client_.connected() && !random_.once(5)) return;
  if (!note(client_.reconnect())) return;
  for (haptic::Session& session : sessions_) (void)note(session.reopen());
}

void MixedClient::step() {
  static constexpr void (MixedClient::*kSteps[])() = {
      &MixedClient::devices, &MixedClient::sessions,   &MixedClient::arm,        &MixedClient::arm,
      &MixedClient::push,    &MixedClient::push,       &MixedClient::read,       &MixedClient::create,
      &MixedClient::create,  &MixedClient::change,     &MixedClient::change,     &MixedClient::look,
      &MixedClient::mesh,    &MixedClient::texture,    &MixedClient::record,     &MixedClient::events,
      &MixedClient::limits,  &MixedClient::properties, &MixedClient::properties, &MixedClient::recover};
  (this->*kSteps[random_.below(std::size(kSteps))])();
}

std::string MixedClient::run() {
  const bool administration = random_.once(3);
  auto connected =
      haptic::Client::connect({administration ? admin_ : control_, name(), administration, std::chrono::seconds(20)});
  if (!connected) return connected.code() == HAPTIC_INTERNAL ? connected.error().message() : "";
  client_ = std::move(*connected);
  for (int left = 5 + random_.below(60); left > 0 && defect_.empty(); --left) {
    step();
    if (random_.once(3)) std::this_thread::sleep_for(milliseconds(random_.below(15)));
  }
  if (!defect_.empty()) return defect_;
  if (random_.once(4)) _exit(0);
  if (random_.once(4)) pause();
  if (random_.once(2)) client_ = haptic::Client(nullptr);  // Before all that was made by it.
  return {};
}

}  // namespace hapticd::test
