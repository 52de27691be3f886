#include "tools/haptic-bench/model/model.h"

#include <fmt/format.h>

#include <cmath>

#include "proto/snapshot.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/mesh_file.h"
#include "tools/haptic-bench/model/nearest.h"
#include "tools/haptic-bench/model/recorded.h"
#include "tools/haptic-bench/model/shapes.h"
#include "tools/haptic-bench/spec.h"
#include "tools/haptic-bench/trajectory/recording_reader.h"

namespace haptic_bench {
namespace {

struct Shape {
  const char* name;
  const char* help;
  Model (*make)(Spec& spec);
};

constexpr Shape kShapes[] = {
    {"sphere", "sphere:radius=0.05,stacks=16: stacks x 2 stacks quads, 4 S (S - 1) triangles",
     [](Spec& s) { return sphere(s.number("radius", 0.05, 1e-5, 10), s.count("stacks", 16, 3, 1000)); }},
    {"plane", "plane:half=0.05,cells=4: cells x cells quads, facing up",
     [](Spec& s) { return plane(s.number("half", 0.05, 1e-5, 10), s.count("cells", 4, 1, 1000)); }},
    {"ridge", "ridge:degrees=45,height=0.005,half=0.05: a ridge along y on a plane",
     [](Spec& s) {
       const double degrees = s.number("degrees", 45, 5, 89);
       return ridge(degrees * EIGEN_PI / 180, s.number("height", 0.005, 1e-5, 1), s.number("half", 0.05, 1e-5, 10));
     }},
    {"bowl", "bowl:radius=0.05,half=0.01,edge=0.0002: the bottom of a hollow sphere",
     [](Spec& s) {
       return bowl(s.number("radius", 0.05, 1e-5, 10), s.number("half", 0.01, 1e-6, 7),
                   s.number("edge", 0.0002, 1e-6, 1));
     }},
};

/** Moves the middle of the box about it to the origin, as hapticctl load --center does. */
void centre(Model& model) {
  const Eigen::AlignedBox3d box = boxOf(model);
  for (auto& vertex : model.vertices) {
    for (int i = 0; i < 3; ++i) vertex[i] = static_cast<float>(vertex[i] - box.center()[i]);
  }
}

/** Metres per unit of a mesh file; 0 where that is not said. */
double scaleOf(Spec& spec) {
  constexpr std::pair<const char*, double> kUnits[] = {{"mm", 1e-3},     {"cm", 1e-2}, {"m", 1},
                                                       {"inch", 0.0254}, {"um", 1e-6}, {"ft", 0.3048}};
  const std::string unit = spec.word("scale", "");
  for (const auto& [name, metres] : kUnits)
    if (unit == name) return metres;
  return spec.number("scale", 0, 1e-9, 1e6);
}

/** A mesh file. One of more than a metre is most likely in millimetres: whoever means it says so. */
Model readScaled(Spec& spec) {
  const double scale = scaleOf(spec);
  Model model = readMeshFile(spec.name(), scale == 0 ? 1 : scale);
  const double side = boxOf(model).sizes().maxCoeff();
  if (scale == 0 && side > 1) {
    throw Failure(spec.name(), fmt::format("it is {:.4g} m long, if its numbers are metres", side),
                  "add their unit: " + spec.name() + ":scale=mm, or scale=m if they are");
  }
  return model;
}

/** Puts it where its settings say. What has been moved is of no kind any more: generators know where theirs stand. */
void place(Spec& spec, Model& model) {
  const hapticd::Pose pose = placement(spec);
  if (pose.p.norm() == 0 && pose.q.vec().norm() == 0) return;
  model.kind = "moved";
  for (std::uint32_t v = 0; v < model.vertices.size(); ++v) {
    const Vec3 x = pose * model.vertex(v);
    if (!(x.cwiseAbs().maxCoeff() <= HD_MAX_COORDINATE)) {
      throw Failure(spec.text(), fmt::format("there its vertices lie up to {:.4g} m away", x.norm()),
                    fmt::format("at most {} m", HD_MAX_COORDINATE));
    }
    for (int i = 0; i < 3; ++i) model.vertices[v][i] = static_cast<float>(x[i]);
  }
}

}  // namespace

std::uint32_t Model::addVertex(const Vec3& x) {
  vertices.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())});
  return static_cast<std::uint32_t>(vertices.size() - 1);
}

void Model::addQuad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  triangles.push_back({a, b, c});
  triangles.push_back({a, c, d});
}

std::string modelHelp() {
  std::string help = "Models:\n";
  for (const Shape& shape : kShapes) help += std::string("  ") + shape.help + "\n";
  return help +
         "  FILE.stl, .obj, .ply ...:scale=m,center=0: a mesh file and its unit (mm, cm, m, inch, um, ft) or metres "
         "per unit,\n"
         "    needed where it would be longer than 1 m; center=1 moves the middle of its box to the origin\n"
         "  FILE.hrec:object=0: the meshes of a recorded session where they stood, or that object alone\n"
         "  Each also x=0,y=0,z=0,turn_x=0,turn_y=0,turn_z=0: where it stands [m], turned by a rotation vector [rad]\n"
         "    (for geodesic, measured, files and recordings; the others run over a shape at the origin)\n";
}

Model makeModel(const std::string& text) {
  Spec spec(text);
  for (const Shape& shape : kShapes) {
    if (spec.name() != shape.name) continue;
    Model model = shape.make(spec);
    place(spec, model);
    spec.finish();
    model.name = text;
    return model;
  }
  Model model;
  if (isRecording(spec.name())) {
    const double object = spec.number("object", 0, 0, 0xffffffffu);
    if (object != std::floor(object))
      throw Failure(text + ", object", "is not a whole number", "as an export of the recording shows it");
    model = readRecordedModel(spec.name(), static_cast<std::uint32_t>(object));
  } else if (spec.name().find('.') == std::string::npos) {
    throw Failure(text, "there is no such model", "sphere, plane, ridge, bowl, a mesh file, or a recording");
  } else {
    model = readScaled(spec);
    if (spec.count("center", 0, 0, 1) != 0) centre(model);
  }
  place(spec, model);
  spec.finish();
  model.name = text;
  return model;
}

}  // namespace haptic_bench
