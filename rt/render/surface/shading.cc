#include "rt/render/surface/shading.h"

#include <algorithm>

#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/render/surface/smooth_normal.h"

namespace hapticd {
namespace {

constexpr double kParallel = 1e-9;  // 1 - cosine: rounding.

/** x turned by the shortest rotation that takes the unit vector `from` to `to` (Rodrigues; they are not opposed). */
Vec3 turned(const Vec3& x, const Vec3& from, const Vec3& to) HD_RT {
  const Vec3 axis = from.cross(to);
  const double cosine = from.dot(to);
  return cosine * x + axis.cross(x) + axis.dot(x) / (1 + cosine) * axis;
}

/** On a crease a ball rolls from the one sheet, which is `smooth`, to the other: facets are `here` and `there`. */
Vec3 overCrease(const SmoothSheet& sheet, std::uint32_t here, std::uint32_t there, const Vec3& x, const Vec3& normal,
                const Vec3& smooth, std::uint32_t& work) HD_RT {
  const Vec3 n_here = sheet.side * faceNormal(sheet.mesh, here), n_there = sheet.side * faceNormal(sheet.mesh, there);
  const double cosine = n_here.dot(n_there), one = normal.dot(n_here), other = normal.dot(n_there);
  if (!(1 - cosine * cosine > kParallel)) return normal;
  const Vec3 beyond = sheet.normalToward(x, there, work);
  if (beyond.isZero(0)) return normal;
  return std::max(0.0, one - cosine * other) * smooth + std::max(0.0, other - cosine * one) * beyond;
}

/** Off a border a ball rolls from facets, those beside it are given, that are `smooth`. */
Vec3 offBorder(const SmoothSheet& sheet, std::uint32_t one, std::uint32_t other, const Vec3& normal,
               const Vec3& smooth) HD_RT {
  const Vec3 n_one = sheet.side * faceNormal(sheet.mesh, one), n_other = sheet.side * faceNormal(sheet.mesh, other);
  const double cosine = n_one.dot(n_other), to_one = normal.dot(n_one), to_other = normal.dot(n_other);
  const Vec3 facets =
      std::max(0.0, to_one - cosine * to_other) * n_one + std::max(0.0, to_other - cosine * to_one) * n_other;
  const double length = facets.norm();  // Of its part across the border.
  return turned(normal, length > kParallel ? Vec3(facets / length) : n_one, smooth);
}

/** Of what holds a proxy, whose push comes from x. In the object's frame. */
Vec3 smoothNormal(const SceneObject& object, const HoldingSurface& held, const Vec3& x, const Vec3& normal,
                  std::uint32_t& work) HD_RT {
  const MeshView& mesh = *object.shape.mesh;
  // Two-sided meshes are felt from the back too. Over a sharp edge a ball rolls until it is behind one facet of it.
  const bool behind = (object.flags & HD_OBJECT_TWO_SIDED) != 0 &&
                      pseudoNormal(mesh, held.feature, held.kind, held.corner, work).dot(normal) < 0;
  const double side = behind ? -1 : 1;
  const SmoothSheet sheet{mesh, object.surface.parameters.smooth_cosine, side};
  SmoothSheet::Corner corner;
  if (held.kind == FeatureKind::kVertex) {
    corner = sheet.cornerAt(held.feature, held.corner, normal, work);
    if (corner.creases != 0 && (corner.creases != 2 || corner.border)) return normal;
  } else if (held.kind == FeatureKind::kEdge && !sheet.isSmooth(held.feature, held.corner)) {
    corner = {2, false, {held.feature, mesh.neighbours[held.feature][held.corner]}};
    if (corner.facet[1] == HD_NO_INDEX) corner = {0, true, {held.feature, held.feature}};
  }
  const Vec3 smooth = sheet.normalToward(x, held.feature, work);
  if (smooth.isZero(0)) return normal;
  const auto [creases, border, facet] = corner;
  if (creases > 0) return overCrease(sheet, facet[0], facet[1], x, normal, smooth, work);
  return border ? offBorder(sheet, facet[0], facet[1], normal, smooth) : smooth;
}

bool isShaded(const SceneObject* object) HD_RT {
  return object && object->shape.kind == ShapeKind::kMesh && object->shape.mesh->neighbours != nullptr &&
         object->surface.parameters.smooth_cosine > 0;
}

/** Of a spring its part across the unit vector n, in parts of that along it, no longer than `most`. */
Vec3 lagOf(const Vec3& spring, const Vec3& n, double most) HD_RT {
  const double along = spring.dot(n);
  if (!(along > 0)) return Vec3::Zero();
  const Vec3 lag = spring / along - n;
  const double length = lag.norm();
  return length > most ? Vec3(most / length * lag) : lag;
}

}  // namespace

/**
 * What is felt of friction, in depths, across `smooth`. In a hollow the proxy that comes over an edge has the next
 * facet's normal at once, and is inside its cone until the hand has caught up (docs/rendering.md, "Friction"). That is
 * the facets' doing: what is felt goes on as it was, and changes as the proxy's lag does from there. What it is more
 * than that fades as the proxy goes on.
 */
Vec3 Shading::lagFelt(const SceneObject& object, const SurfaceContact& contact, const Vec3& spring,
                      const Vec3& smooth) HD_RT {
  const Quat q_OW = object.X_WO.q.conjugate();
  const Vec3 n = q_OW * contact.normal, at = q_OW * (contact.proxy - object.X_WO.p);
  const double left = std::max(0.0, 1 + std::min(0.0, contact.damping) / (contact.stiffness * contact.depth));
  const double coefficient = contact.slip ? contact.friction.sliding : contact.friction.still;
  const Vec3 lag = spring / contact.depth - n;
  const double most = std::max(left * coefficient, lag.norm());
  if (object_ == object.id && smooth.dot(smooth_) >= kLeastTurnCosine) {
    // The present facet's normal as it were if the smooth surface had not turned since.
    const Vec3 then = turned(n, smooth, smooth_);
    const Vec3 offset = turned(felt_, smooth_, then) - lagOf(spring_, then, most);
    const double fade = std::max(0.0, 1 - (at - at_).norm() / contact.depth);
    offset_ = fade * turned(offset, then, n);
  } else {
    offset_.setZero();
  }
  Vec3 felt = lag + offset_ - offset_.dot(n) * n;
  if (const double length = felt.norm(); length > most) felt *= most / length;
  offset_ = felt - lag;
  object_ = object.id;
  spring_ = spring;
  at_ = at;
  smooth_ = smooth;
  return felt_ = turned(felt, n, smooth);
}

void Shading::step(const Scene& scene, std::span<const HoldingSurface> holding, const Vec3& v_W,
                   SurfaceContact& contact) HD_RT {
  const SceneObject* touched = holding.empty() ? nullptr : scene.find(contact.object);
  const bool shaded =
      std::ranges::any_of(holding, [&](const HoldingSurface& held) HD_RT { return isShaded(scene.find(held.object)); });
  if (!touched || !shaded || !(contact.depth > 0 && contact.stiffness > 0)) {
    reset();
    return;
  }
  const Vec3 offset = object_ == contact.object ? Vec3(contact.depth * (touched->X_WO.q * offset_)) : Vec3::Zero();
  Vec3 smooth = contact.depth * contact.normal;
  for (const HoldingSurface& held : holding) {
    const SceneObject* object = scene.find(held.object);
    if (isShaded(object)) {
      const Quat q_OW = object->X_WO.q.conjugate();
      const Vec3 x = contact.proxy + offset - held.push * held.normal;
      const Vec3 normal =
          object->X_WO.q *
          smoothNormal(*object, held, q_OW * (x - object->X_WO.p), q_OW * held.normal, contact.work).normalized();
      smooth += object->material.stiffness / contact.stiffness * held.push * (normal - held.normal);
    }
  }
  const double length = smooth.norm();
  if (!(smooth.dot(contact.normal) >= kLeastTurnCosine * length && length > 0)) {
    smooth = contact.normal;
  } else {
    smooth /= length;
  }

  contact.smooth = smooth;
  const Vec3& spring = contact.pull;
  Vec3 along = smooth;
  if (contact.friction.still > 0) {
    const Quat& q = touched->X_WO.q;
    along += q * lagFelt(*touched, contact, q.conjugate() * spring, q.conjugate() * smooth);
  } else {
    reset();
  }
  const Vec3 felt = contact.stiffness * spring.norm() / along.norm() * along;
  const double approach = smooth.dot(contact.at_hip - v_W);
  contact.damping = std::max(contact.damping_gain * approach, -felt.dot(smooth));
  const Vec3 force = felt + contact.damping * smooth;
  contact.apart += (force - contact.force).cwiseProduct(contact.at_hip - contact.velocity);
  contact.force = force;
}

}  // namespace hapticd
