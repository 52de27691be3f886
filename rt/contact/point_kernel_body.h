/** @file
 * The text of every PointKernel. Included last by a file that has defined in an unnamed namespace: F and I (sixteen
 * floats, sixteen 32-bit integers), M (sixteen bits) and the functions on them that are used below. Everything here is
 * in an unnamed namespace too: each file keeps its own.
 */
// No include guard: it is the body of one file each.

namespace hapticd {
namespace {

constexpr float kHalfDiagonal = 0.8660255F;  // sqrt(3) / 2 of a voxel, rounded up
constexpr float kDiagonal = 1.7320509F;
constexpr float kFraction = 16384;  // Steps of the weights along x: two of them and their product fit 16 bits and 32.
constexpr float kFar = 1e9F;
constexpr std::uint32_t kNone = 0xffffffffu;

struct Place3 {
  F x, y, z;
};

HD_LANES Place3 placed(const Placement& p, F x, F y, F z) {
  const auto along = [&](int a) HD_LANES_LAMBDA {
    return add(add(add(mul(all(p.row[a][0]), x), mul(all(p.row[a][1]), y)), mul(all(p.row[a][2]), z)), all(p.shift[a]));
  };
  return {along(0), along(1), along(2)};
}

/** The nearest place within the lattice. */
HD_LANES Place3 within(const FieldTable& f, const Place3& u) {
  const F zero = all(0.0F);
  return {least(greatest(u.x, zero), all(f.top[0])), least(greatest(u.y, zero), all(f.top[1])),
          least(greatest(u.z, zero), all(f.top[2]))};
}

/** Eight values about a place, by twos along x in one word; and the place among them, 0 to 1. */
struct Voxel {
  Corners v;
  F fx, fy, fz;
};

HD_LANES F between(F a, F b, F t) { return add(a, mul(t, sub(b, a))); }

/** Between the values along x: in steps times kFraction. */
struct Edges {
  F c00, c10, c01, c11;
  F value, dz;  ///< Between them all; its slope along z, per side.
};

HD_LANES Edges interpolated(const Voxel& u) {
  const I high = toInt(mul(u.fx, all(kFraction)));
  const I weights = orInt(subInt(allInt(static_cast<std::int32_t>(kFraction)), high), shiftLeft16(high));
  Edges e;
  e.c00 = toFloat(pairs(u.v.v00, weights));
  e.c10 = toFloat(pairs(u.v.v10, weights));
  e.c01 = toFloat(pairs(u.v.v01, weights));
  e.c11 = toFloat(pairs(u.v.v11, weights));
  const F y0 = between(e.c00, e.c10, u.fy), y1 = between(e.c01, e.c11, u.fy);
  e.dz = sub(y1, y0);
  e.value = add(y0, mul(u.fz, e.dz));
  return e;
}

/** In steps times kFraction, per side. */
HD_LANES Place3 sloped(const Voxel& u, const Edges& e) {
  const I difference = allInt(0x0001ffff);  // -1 and +1
  const F s00 = toFloat(pairs(u.v.v00, difference)), s10 = toFloat(pairs(u.v.v10, difference));
  const F s01 = toFloat(pairs(u.v.v01, difference)), s11 = toFloat(pairs(u.v.v11, difference));
  return {mul(between(between(s00, s10, u.fy), between(s01, s11, u.fy), u.fz), all(kFraction)),
          between(sub(e.c10, e.c00), sub(e.c11, e.c01), u.fz), e.dz};
}

/** Where there is no brick: between the corners of the cell. */
HD_LANES Voxel coarsely(const FieldTable& f, I ix, I iy, I iz, const Place3& at) {
  const auto nx = static_cast<std::int32_t>(f.cells[0] + 1);
  const std::int32_t layer = nx * static_cast<std::int32_t>(f.cells[1] + 1);
  const I index = addInt(ix, addInt(mulInt(iy, allInt(nx)), mulInt(iz, allInt(layer))));
  const F eighth = all(0.125F);
  const F fx = sub(mul(at.x, eighth), toFloat(ix)), fy = sub(mul(at.y, eighth), toFloat(iy)),
          fz = sub(mul(at.z, eighth), toFloat(iz));
  return {{gatherPairs(f.coarse, index), gatherPairs(f.coarse + nx, index), gatherPairs(f.coarse + layer, index),
           gatherPairs(f.coarse + layer + nx, index)},
          fx,
          fy,
          fz};
}

HD_LANES F lowHalf(I pair) { return toFloat(shiftRight16(shiftLeft16(pair))); }

HD_LANES M lanesOf(std::uint32_t block, std::uint32_t first, std::uint32_t end) {
  std::uint32_t lanes = 0xffffu;
  if (block < first) lanes &= 0xffffu << (first - block);
  if (block + 16 > end) lanes &= 0xffffu >> (block + 16 - end);
  return static_cast<M>(lanes);
}

/** A block on its way: where its points are, then which value is at the lower corner of each point's voxel. */
struct Looked {
  Place3 at;
  Lanes16 index;  ///< Of the cell, then of the value.
  M lanes;
  M without;  ///< Lanes without a brick.
};

/** A block that one corner of its voxels does not rule out. */
struct Survivor {
  Place3 at;
  Corners v;
  std::uint32_t block;
  M near;    ///< Lanes with a brick.
  M inside;  ///< Lanes without, deep inside.
};
constexpr int kAhead = 8;

/** Without a margin what touches is inside, and weighs what it presses. */
template <bool kMargin>
float runRange(const FieldTable& field, const PointTable& points, const Placement& placement, const PointRange& range,
               PointSums& sums) noexcept {
  using S = PointSums;
  const std::uint32_t end = range.first + range.count;
  const F fine = all(field.fine_step / kFraction), coarse = all(field.coarse_step / kFraction);
  const F margin = all(range.margin), zero = all(0.0F), weight = all(range.weight);
  const F beyond = all((range.margin + kDiagonal) / field.fine_step);
  const I cells_x = allInt(static_cast<std::int32_t>(field.cells[0]));
  const I layer = allInt(static_cast<std::int32_t>(field.cells[0] * field.cells[1]));
  const I corners_x = allInt(static_cast<std::int32_t>(field.cells[0] + 1));
  const I corners = allInt(static_cast<std::int32_t>((field.cells[0] + 1) * (field.cells[1] + 1)));
  F nearest = all(kFar);
  std::uint32_t touching = 0;
  F deepest = load(sums.deepest);
  F area_sum = load(sums.sum[S::kArea]), weight_sum = load(sums.sum[S::kWeight]);
  F force_x = load(sums.sum[S::kForce]), force_y = load(sums.sum[S::kForce + 1]),
    force_z = load(sums.sum[S::kForce + 2]);
  F torque_x = load(sums.sum[S::kTorque]), torque_y = load(sums.sum[S::kTorque + 1]),
    torque_z = load(sums.sum[S::kTorque + 2]);
  F mean_x = load(sums.sum[S::kMean]), mean_y = load(sums.sum[S::kMean + 1]), mean_z = load(sums.sum[S::kMean + 2]);
  std::uint32_t block = range.first & ~15u;
  while (block < end) {
    // Step by step for some blocks together: none waits for another, so misses of the cache overlap.
    Looked looked[kAhead];
    const std::uint32_t base = block;
    int blocks = 0;
    for (; block < end && blocks < kAhead; block += 16) {
      Looked& l = looked[blocks++];
      l.lanes = lanesOf(block, range.first, end);
      l.at = within(field, placed(placement, load(points.x + block), load(points.y + block), load(points.z + block)));
      const I cx = shiftRight3(toInt(l.at.x)), cy = shiftRight3(toInt(l.at.y)), cz = shiftRight3(toInt(l.at.z));
      keep(l.index, addInt(cx, addInt(mulInt(cy, cells_x), mulInt(cz, layer))));
    }
    for (int i = 0; i < blocks; ++i) {
      Looked& l = looked[i];
      const I ix = toInt(l.at.x), iy = toInt(l.at.y), iz = toInt(l.at.z);
      const I brick = gatherKept(field.cell, l.index);
      l.without = static_cast<M>(equalInt(brick, allInt(static_cast<std::int32_t>(kNone))) & l.lanes);
      const I seven = allInt(7);
      const I local = addInt(andInt(ix, seven),
                             addInt(mulInt(andInt(iy, seven), allInt(9)), mulInt(andInt(iz, seven), allInt(81))));
      keep(l.index, masked(static_cast<M>(l.lanes & ~l.without), addInt(mulInt(brick, allInt(736)), local)));
    }
    Survivor survivors[kAhead];
    int count = 0;
    for (int i = 0; i < blocks; ++i) {
      const Looked& l = looked[i];
      Corners v = firstCorners(field.bricks, l.index);
      const M with = static_cast<M>(l.lanes & ~l.without);
      M near = with, inside = 0;
      // The values grow no faster than places: one corner far away tells of them all.
      if ((lessEqual(lowHalf(v.v00), beyond) & with) == 0) {
        const F bound = sub(mul(lowHalf(v.v00), all(field.fine_step)), all(kDiagonal));
        nearest = least(nearest, choose(with, bound, all(kFar)));
        near = 0;
      }
      if (l.without != 0) {
        nearest = least(nearest, choose(l.without, zero, all(kFar)));  // Says nothing: the border may be near.
        // The surface does not cross a cell without a brick: one corner tells on which side it is.
        const I cx = shiftRight3(toInt(l.at.x)), cy = shiftRight3(toInt(l.at.y)), cz = shiftRight3(toInt(l.at.z));
        const I corner = addInt(cx, addInt(mulInt(cy, corners_x), mulInt(cz, corners)));
        inside = static_cast<M>(less(lowHalf(gatherPairs(field.coarse, corner)), zero) & l.without);
      }
      if ((near | inside) == 0) continue;
      otherCorners(field.bricks, l.index, v);
      survivors[count++] = {l.at, v, base + 16 * static_cast<std::uint32_t>(i), near, inside};
    }
    for (int i = 0; i < count; ++i) {
      const Survivor& here = survivors[i];
      const Place3 at = here.at;
      const I ix = toInt(at.x), iy = toInt(at.y), iz = toInt(at.z);
      const Voxel fine_voxel{here.v, sub(at.x, toFloat(ix)), sub(at.y, toFloat(iy)), sub(at.z, toFloat(iz))};
      const Edges fine_edges = interpolated(fine_voxel);
      F distance = choose(here.near, mul(fine_edges.value, fine), all(kFar));
      nearest = least(nearest, distance);
      Place3 deep{zero, zero, zero};  // The coarse field's gradient.
      if (here.inside != 0) {
        const Voxel cell = coarsely(field, shiftRight3(ix), shiftRight3(iy), shiftRight3(iz), at);
        const Edges edges = interpolated(cell);
        const Place3 s = sloped(cell, edges);
        const F per_voxel = mul(coarse, all(0.125F));
        deep = {mul(s.x, per_voxel), mul(s.y, per_voxel), mul(s.z, per_voxel)};
        distance = choose(here.inside, mul(edges.value, coarse), distance);
      }
      const M touch = less(distance, margin);
      if (touch == 0) continue;
      touching += static_cast<std::uint32_t>(__builtin_popcount(touch));
      const F area = choose(touch, mul(loadAreas(points.area + here.block), weight), zero);
      const F depth = sub(zero, distance);
      deepest = greatest(deepest, choose(touch, depth, all(-kFar)));
      const F x = sub(at.x, all(range.middle[0])), y = sub(at.y, all(range.middle[1])),
              z = sub(at.z, all(range.middle[2]));
      const Place3 slopes = sloped(fine_voxel, fine_edges);
      F nx = mul(slopes.x, fine), ny = mul(slopes.y, fine), nz = mul(slopes.z, fine);
      if (here.inside != 0) {
        nx = choose(here.inside, deep.x, nx);
        ny = choose(here.inside, deep.y, ny);
        nz = choose(here.inside, deep.z, nz);
      }
      const M inside = kMargin ? less(distance, zero) : touch;
      const F pressed = kMargin ? mul(choose(inside, depth, zero), area) : mul(depth, area);
      const F px = mul(pressed, nx), py = mul(pressed, ny), pz = mul(pressed, nz);
      area_sum = add(area_sum, kMargin ? choose(inside, area, zero) : area);
      force_x = add(force_x, px);
      force_y = add(force_y, py);
      force_z = add(force_z, pz);
      torque_x = add(torque_x, sub(mul(y, pz), mul(z, py)));
      torque_y = add(torque_y, sub(mul(z, px), mul(x, pz)));
      torque_z = add(torque_z, sub(mul(x, py), mul(y, px)));
      const F near = kMargin ? mul(choose(touch, add(margin, depth), zero), area) : pressed;
      weight_sum = add(weight_sum, near);
      mean_x = add(mean_x, mul(near, x));
      mean_y = add(mean_y, mul(near, y));
      mean_z = add(mean_z, mul(near, z));
      if (kMargin) {
        store(sums.sum[S::kNormal], add(load(sums.sum[S::kNormal]), mul(near, nx)));
        store(sums.sum[S::kNormal + 1], add(load(sums.sum[S::kNormal + 1]), mul(near, ny)));
        store(sums.sum[S::kNormal + 2], add(load(sums.sum[S::kNormal + 2]), mul(near, nz)));
      }
    }
  }
  if (touching != 0) {
    store(sums.deepest, deepest);
    store(sums.sum[S::kArea], area_sum);
    store(sums.sum[S::kWeight], weight_sum);
    store(sums.sum[S::kForce], force_x);
    store(sums.sum[S::kForce + 1], force_y);
    store(sums.sum[S::kForce + 2], force_z);
    store(sums.sum[S::kTorque], torque_x);
    store(sums.sum[S::kTorque + 1], torque_y);
    store(sums.sum[S::kTorque + 2], torque_z);
    store(sums.sum[S::kMean], mean_x);
    store(sums.sum[S::kMean + 1], mean_y);
    store(sums.sum[S::kMean + 2], mean_z);
  }
  sums.touching += touching;
  return leastOf(nearest);
}

float run(const FieldTable& field, const PointTable& points, const Placement& placement, const PointRange& range,
          PointSums& sums) noexcept {
  return range.margin > 0 ? runRange<true>(field, points, placement, range, sums)
                          : runRange<false>(field, points, placement, range, sums);
}

void reduce(const PointSums& sums, float* out) noexcept {
  for (int i = 0; i < PointSums::kCount; ++i) out[i] = sumOf(load(sums.sum[i]));
  out[PointSums::kCount] = -leastOf(sub(all(0.0F), load(sums.deepest)));
}

void bound(const FieldTable& field, const PatchTable& patches, const Placement& placement, std::uint32_t first,
           float* bounds) noexcept {
  const Place3 u = placed(placement, load(patches.x + first), load(patches.y + first), load(patches.z + first));
  const Place3 at = within(field, u);
  const I ix = toInt(at.x), iy = toInt(at.y), iz = toInt(at.z);
  const I cx = shiftRight3(ix), cy = shiftRight3(iy), cz = shiftRight3(iz);
  const I cells_x = allInt(static_cast<std::int32_t>(field.cells[0]));
  const I layer = allInt(static_cast<std::int32_t>(field.cells[0] * field.cells[1]));
  const I brick = gather(field.cell, addInt(cx, addInt(mulInt(cy, cells_x), mulInt(cz, layer))));
  const M without = equalInt(brick, allInt(static_cast<std::int32_t>(kNone)));
  const F half = all(0.5F), eighth = all(0.125F);
  // The value at the nearest lattice point or corner, less the way to it and the way from a corner of any voxel that
  // the ball reaches into.
  F value;
  {
    const I seven = allInt(7);
    const auto rounded = [&](F a, I i)
                             HD_LANES_LAMBDA { return toInt(add(sub(a, toFloat(subInt(i, andInt(i, seven)))), half)); };
    const I local =
        addInt(rounded(at.x, ix), addInt(mulInt(rounded(at.y, iy), allInt(9)), mulInt(rounded(at.z, iz), allInt(81))));
    const I index = masked(static_cast<M>(~without), addInt(mulInt(brick, allInt(736)), local));
    value = sub(mul(lowHalf(gatherPairs(field.bricks, index)), all(field.fine_step)), all(kHalfDiagonal));
  }
  if (without != 0) {
    const auto nx = static_cast<std::int32_t>(field.cells[0] + 1);
    const std::int32_t layers = nx * static_cast<std::int32_t>(field.cells[1] + 1);
    // Each corner bounds from below; the one farthest out, seen from the surface, bounds best.
    const I index = addInt(cx, addInt(mulInt(cy, allInt(nx)), mulInt(cz, allInt(layers))));
    const F fx = sub(mul(at.x, eighth), toFloat(cx)), fy = sub(mul(at.y, eighth), toFloat(cy)),
            fz = sub(mul(at.z, eighth), toFloat(cz));
    const F gx = sub(all(1.0F), fx), gy = sub(all(1.0F), fy), gz = sub(all(1.0F), fz);
    F best = all(-kFar);
    for (int corner = 0; corner < 4; ++corner) {
      const I pair = gatherPairs(field.coarse + (corner & 1 ? nx : 0) + (corner & 2 ? layers : 0), index);
      const F y = corner & 1 ? gy : fy, z = corner & 2 ? gz : fz;
      const F across = add(mul(y, y), mul(z, z));
      const F low = mul(lowHalf(pair), all(field.coarse_step));
      const F high = mul(toFloat(shiftRight16(pair)), all(field.coarse_step));
      best = greatest(best, sub(low, mul(all(8.0F), root(add(across, mul(fx, fx))))));
      best = greatest(best, sub(high, mul(all(8.0F), root(add(across, mul(gx, gx))))));
    }
    value = choose(without, best, value);
  }
  const F bx = sub(u.x, at.x), by = sub(u.y, at.y), bz = sub(u.z, at.z);
  const F away = root(add(add(mul(bx, bx), mul(by, by)), mul(bz, bz)));
  // Beyond the lattice: all surface lies in its box, and from its nearest place at no acute angle.
  const F here = greatest(value, zeroOf());
  const F outside = choose(less(zeroOf(), away), root(add(mul(here, here), mul(away, away))), value);
  const F steps = all(0.01F + field.fine_step + field.coarse_step);  // Rounding of values and places.
  store(bounds, sub(sub(sub(outside, load(patches.radius + first)), all(kHalfDiagonal)), steps));
}

std::uint32_t expire(float* clearance, const float* lever, float shift, float turn) noexcept {
  const F moved = add(all(shift), mul(all(turn), load(lever)));
  const F left = sub(mul(load(clearance), all(1 - 0x1p-22F)), moved);
  store(clearance, left);
  return lessEqual(left, zeroOf());
}

}  // namespace
}  // namespace hapticd
