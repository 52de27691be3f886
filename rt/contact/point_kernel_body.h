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

/** Eight values about a place and the place among them. */
struct Sampled {
  F value;  ///< In steps times kFraction; so are the slopes, per side.
  F dx, dy, dz;
};

HD_LANES F between(F a, F b, F t) { return add(a, mul(t, sub(b, a))); }

/** `low`: values at the lower corner and at its neighbour along x, both in one word; the others a row, a layer away. */
HD_LANES Sampled interpolated(I v00, I v10, I v01, I v11, F fx, F fy, F fz) {
  const I high = toInt(mul(fx, all(kFraction)));
  const I weights = orInt(subInt(allInt(static_cast<std::int32_t>(kFraction)), high), shiftLeft16(high));
  const I difference = allInt(0x0001ffff);  // -1 and +1
  const F scale = all(kFraction);
  const F c00 = toFloat(pairs(v00, weights)), c10 = toFloat(pairs(v10, weights));
  const F c01 = toFloat(pairs(v01, weights)), c11 = toFloat(pairs(v11, weights));
  const F s00 = toFloat(pairs(v00, difference)), s10 = toFloat(pairs(v10, difference));
  const F s01 = toFloat(pairs(v01, difference)), s11 = toFloat(pairs(v11, difference));
  const F y0 = between(c00, c10, fy), y1 = between(c01, c11, fy);
  const F dz = sub(y1, y0);
  return {add(y0, mul(fz, dz)), mul(between(between(s00, s10, fy), between(s01, s11, fy), fz), scale),
          between(sub(c10, c00), sub(c11, c01), fz), dz};
}

/** Where there is no brick: between the corners of the cell. */
HD_LANES Sampled coarsely(const FieldTable& f, I ix, I iy, I iz, const Place3& at) {
  const auto nx = static_cast<std::int32_t>(f.cells[0] + 1);
  const std::int32_t layer = nx * static_cast<std::int32_t>(f.cells[1] + 1);
  const I index = addInt(ix, addInt(mulInt(iy, allInt(nx)), mulInt(iz, allInt(layer))));
  const F eighth = all(0.125F);
  const F fx = sub(mul(at.x, eighth), toFloat(ix)), fy = sub(mul(at.y, eighth), toFloat(iy)),
          fz = sub(mul(at.z, eighth), toFloat(iz));
  return interpolated(gatherPairs(f.coarse, index), gatherPairs(f.coarse + nx, index),
                      gatherPairs(f.coarse + layer, index), gatherPairs(f.coarse + layer + nx, index), fx, fy, fz);
}

HD_LANES F lowHalf(I pair) { return toFloat(shiftRight16(shiftLeft16(pair))); }

HD_LANES M lanesOf(std::uint32_t block, std::uint32_t first, std::uint32_t end) {
  std::uint32_t lanes = 0xffffu;
  if (block < first) lanes &= 0xffffu << (first - block);
  if (block + 16 > end) lanes &= 0xffffu >> (block + 16 - end);
  return static_cast<M>(lanes);
}

/** A block that one corner of its voxels does not rule out. */
struct Survivor {
  Place3 at;
  I v00, v01, index;
  std::uint32_t block;
  M near;    ///< Lanes with a brick.
  M inside;  ///< Lanes without, deep inside.
};
constexpr int kAhead = 8;

float run(const FieldTable& field, const PointTable& points, const Placement& placement, const PointRange& range,
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
    // First a look at one corner of each point's voxel, which no other block waits for: misses of the cache overlap.
    Survivor survivors[kAhead];
    int count = 0;
    for (; block < end && count < kAhead; block += 16) {
      const M lanes = lanesOf(block, range.first, end);
      const Place3 at =
          within(field, placed(placement, load(points.x + block), load(points.y + block), load(points.z + block)));
      const I ix = toInt(at.x), iy = toInt(at.y), iz = toInt(at.z);
      const I cx = shiftRight3(ix), cy = shiftRight3(iy), cz = shiftRight3(iz);
      const I brick = gather(field.cell, addInt(cx, addInt(mulInt(cy, cells_x), mulInt(cz, layer))));
      const M without = static_cast<M>(equalInt(brick, allInt(static_cast<std::int32_t>(kNone))) & lanes);
      const M with = static_cast<M>(lanes & ~without);
      const I seven = allInt(7);
      const I local = addInt(andInt(ix, seven),
                             addInt(mulInt(andInt(iy, seven), allInt(9)), mulInt(andInt(iz, seven), allInt(81))));
      const I index = masked(with, addInt(mulInt(brick, allInt(736)), local));
      const I v00 = gatherPairs(field.bricks, index);
      M near = with, inside = 0;
      // The values grow no faster than places: one corner far away tells of them all.
      if ((lessEqual(lowHalf(v00), beyond) & with) == 0) {
        const F bound = sub(mul(lowHalf(v00), all(field.fine_step)), all(kDiagonal));
        nearest = least(nearest, choose(with, bound, all(kFar)));
        near = 0;
      }
      if (without != 0) {
        nearest = least(nearest, choose(without, zero, all(kFar)));  // Says nothing: the border may be near.
        // The surface does not cross a cell without a brick: one corner tells on which side it is.
        const I corner = addInt(cx, addInt(mulInt(cy, corners_x), mulInt(cz, corners)));
        inside = static_cast<M>(less(lowHalf(gatherPairs(field.coarse, corner)), zero) & without);
      }
      if ((near | inside) == 0) continue;
      // The layer above lies in other lines of the cache: ask for them here as well.
      survivors[count++] = {at, v00, gatherPairs(field.bricks + 81, index), index, block, near, inside};
    }
    for (int i = 0; i < count; ++i) {
      const Survivor& here = survivors[i];
      const Place3 at = here.at;
      const I ix = toInt(at.x), iy = toInt(at.y), iz = toInt(at.z);
      const Sampled fine_values = interpolated(here.v00, gatherPairs(field.bricks + 9, here.index), here.v01,
                                               gatherPairs(field.bricks + 90, here.index), sub(at.x, toFloat(ix)),
                                               sub(at.y, toFloat(iy)), sub(at.z, toFloat(iz)));
      Sampled got = fine_values;
      F distance = choose(here.near, mul(got.value, fine), all(kFar)), slope = fine;
      nearest = least(nearest, distance);
      if (here.inside != 0) {
        const Sampled s = coarsely(field, shiftRight3(ix), shiftRight3(iy), shiftRight3(iz), at);
        distance = choose(here.inside, mul(s.value, coarse), distance);
        slope = choose(here.inside, mul(coarse, all(0.125F)), slope);
        got.dx = choose(here.inside, s.dx, got.dx);
        got.dy = choose(here.inside, s.dy, got.dy);
        got.dz = choose(here.inside, s.dz, got.dz);
      }
      const M touch = less(distance, margin);
      if (touch == 0) continue;
      touching += static_cast<std::uint32_t>(__builtin_popcount(touch));
      const F area = choose(touch, mul(loadAreas(points.area + here.block), weight), zero);
      const F depth = sub(zero, distance);
      deepest = greatest(deepest, choose(touch, depth, all(-kFar)));
      const F x = sub(at.x, all(range.middle[0])), y = sub(at.y, all(range.middle[1])),
              z = sub(at.z, all(range.middle[2]));
      const F nx = mul(got.dx, slope), ny = mul(got.dy, slope), nz = mul(got.dz, slope);
      const M inside = less(distance, zero);
      const F pressed = mul(choose(inside, depth, zero), area);
      const F px = mul(pressed, nx), py = mul(pressed, ny), pz = mul(pressed, nz);
      area_sum = add(area_sum, choose(inside, area, zero));
      force_x = add(force_x, px);
      force_y = add(force_y, py);
      force_z = add(force_z, pz);
      torque_x = add(torque_x, sub(mul(y, pz), mul(z, py)));
      torque_y = add(torque_y, sub(mul(z, px), mul(x, pz)));
      torque_z = add(torque_z, sub(mul(x, py), mul(y, px)));
      const F near = mul(choose(touch, add(margin, depth), zero), area);
      weight_sum = add(weight_sum, near);
      mean_x = add(mean_x, mul(near, x));
      mean_y = add(mean_y, mul(near, y));
      mean_z = add(mean_z, mul(near, z));
      if (range.margin > 0) {
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
