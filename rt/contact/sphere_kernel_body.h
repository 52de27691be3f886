/** @file
 * The text of every PointKernel's functions for spheres: as point_kernel_body.h, and included after it.
 */
// No include guard: it is the body of one file each.

namespace hapticd {
namespace {

/** The fine field about 16 places within the lattice. */
struct Fine {
  Voxel voxel;
  Place3 bent;  ///< Its second differences along the axes, in steps.
  M without;    ///< Lanes without a brick: their values mean nothing.
};

HD_LANES I sumOfPair(I pair) { return pairs(pair, allInt(0x00010001)); }

/** From three values in a row of the brick, the third beyond the voxel or before it. */
HD_LANES F bentBy(M beyond, I first, I second, I third) {
  const F a = toFloat(first), b = toFloat(second);
  const F middle = choose(beyond, b, a), end = choose(beyond, a, b);
  return add(sub(toFloat(third), add(middle, middle)), end);
}

HD_LANES Fine finely(const FieldTable& field, const Place3& at) {
  const I ix = toInt(at.x), iy = toInt(at.y), iz = toInt(at.z), seven = allInt(7);
  const I layer = allInt(static_cast<std::int32_t>(field.cells[0] * field.cells[1]));
  Lanes16 index;
  keep(index, addInt(shiftRight3(ix), addInt(mulInt(shiftRight3(iy), allInt(static_cast<std::int32_t>(field.cells[0]))),
                                             mulInt(shiftRight3(iz), layer))));
  const I brick = gatherKept(field.cell, index);
  Fine f;
  f.without = equalInt(brick, allInt(static_cast<std::int32_t>(kNone)));
  const I lx = andInt(ix, seven), ly = andInt(iy, seven), lz = andInt(iz, seven);
  const I local = addInt(lx, addInt(mulInt(ly, allInt(9)), mulInt(lz, allInt(81))));
  const M with = static_cast<M>(~f.without);
  const I lower = masked(with, addInt(mulInt(brick, allInt(736)), local));
  keep(index, lower);
  Voxel& u = f.voxel;
  u = {firstCorners(field.bricks, index), sub(at.x, toFloat(ix)), sub(at.y, toFloat(iy)), sub(at.z, toFloat(iz))};
  otherCorners(field.bricks, index, u.v);
  // Towards the middle of the brick there is one more.
  const auto beyond = [&](I l) HD_LANES_LAMBDA { return static_cast<M>(less(toFloat(l), all(4.0F)) | f.without); };
  const auto third = [&](M m, int stride) HD_LANES_LAMBDA {
    const I to = addInt(masked(m, allInt(3 * stride)), allInt(-stride));
    return gatherPairs(field.bricks, addInt(lower, to));
  };
  const M mx = beyond(lx), my = beyond(ly), mz = beyond(lz);
  const F half = all(0.5F);
  f.bent.x =
      bentBy(mx, shiftRight16(shiftLeft16(u.v.v00)), shiftRight16(u.v.v00), shiftRight16(shiftLeft16(third(mx, 1))));
  f.bent.y = mul(half, bentBy(my, sumOfPair(u.v.v00), sumOfPair(u.v.v10), sumOfPair(third(my, 9))));
  f.bent.z = mul(half, bentBy(mz, sumOfPair(u.v.v00), sumOfPair(u.v.v01), sumOfPair(third(mz, 81))));
  return f;
}

HD_LANES F size(F a) { return greatest(a, sub(zeroOf(), a)); }

constexpr float kLeastSlope = 1e-3F;  // Less is the middle between two walls, which shows no way to either.
constexpr float kMostBent = 0.15F;    // Second differences [voxel]: what bends more is a crease, and tells nothing.

HD_LANES F squaredAbove(F a) {
  const F above = greatest(a, zeroOf());
  return mul(above, above);
}

/** Area that a plane with normal n, at t >= 0 from the middle of a cube of side 1, cuts out of it: where three boxes as
 * wide as n's components, folded together, stand at t. */
HD_LANES F section(const Place3& n, F t) {
  const F least_width = all(0.01F);  // Narrower, single precision would show.
  const F a = greatest(size(n.x), least_width), b = greatest(size(n.y), least_width),
          c = greatest(size(n.z), least_width);
  const F u = sub(mul(all(0.5F), add(add(a, b), c)), t);
  const F ua = sub(u, a), ub = sub(u, b), uc = sub(u, c);
  const F corners = sub(sub(sub(squaredAbove(u), squaredAbove(ua)), squaredAbove(ub)), squaredAbove(uc));
  const F edges = add(add(squaredAbove(sub(ua, b)), squaredAbove(sub(ub, c))), squaredAbove(sub(uc, a)));
  return greatest(quotient(add(corners, edges), mul(all(2.0F), mul(mul(a, b), c))), zeroOf());
}

void settle(const FieldTable& field, const Placement& placement, const PlaceTable& places,
            std::uint32_t count) noexcept {
  const F fine = all(field.fine_step / kFraction), voxel = all(places.voxel), far = all(kHalfDiagonal * places.side);
  const F one_side = all(1 / places.side), one = all(1.0F);
  const F most_bent = all(kMostBent / field.fine_step), least_slope = all(kLeastSlope * kFraction / field.fine_step);
  for (std::uint32_t block = 0; block < count; block += 16) {
    const F x = load(places.x + block), y = load(places.y + block), z = load(places.z + block);
    const Fine f = finely(field, within(field, placed(placement, x, y, z)));
    const Voxel& u = f.voxel;
    const Edges edges = interpolated(u);
    const Place3 g = sloped(u, edges);
    const F squared = add(add(mul(g.x, g.x), mul(g.y, g.y)), mul(g.z, g.z));
    const F slope = root(squared);
    const M unknown = static_cast<M>(f.without | less(slope, least_slope));
    const F over = quotient(one, greatest(slope, least_slope));
    const Place3 n{mul(g.x, over), mul(g.y, over), mul(g.z, over)};
    // What is interpolated between is off by half of f'' x (1 - x) along each axis.
    const auto part = [&](F bent, F at) HD_LANES_LAMBDA {
      return choose(less(size(bent), most_bent), mul(bent, mul(at, sub(one, at))), zeroOf());
    };
    const F off = add(add(part(f.bent.x, u.fx), part(f.bent.y, u.fy)), part(f.bent.z, u.fz));
    const F distance = sub(mul(edges.value, fine), mul(off, all(0.5F * field.fine_step)));
    const F back = choose(unknown, zeroOf(), greatest(least(sub(zeroOf(), distance), far), sub(zeroOf(), far)));
    store(places.x + block, add(x, mul(voxel, mul(back, n.x))));
    store(places.y + block, add(y, mul(voxel, mul(back, n.y))));
    store(places.z + block, add(z, mul(voxel, mul(back, n.z))));
    const F cut = section(n, mul(size(back), one_side));
    storeAreas(places.share + block, choose(unknown, all(kMeanShare), mul(all(kShareSteps), cut)));
  }
}

std::uint64_t meet(const BallTable& balls, const float (&from)[3], const float (&at)[3], std::uint64_t mask,
                   BallSums* sums) noexcept {
  const F reach = all(balls.reach), squared_reach = all(balls.reach * balls.reach), follow = all(balls.follow);
  std::uint64_t hits = 0;
  for (int first = 0; first < 64; first += 16) {
    const M asked = static_cast<M>(mask >> first);
    if (asked == 0) continue;
    const F ox = load(balls.x + first), oy = load(balls.y + first), oz = load(balls.z + first);
    const F x = add(all(from[0]), ox), y = add(all(from[1]), oy), z = add(all(from[2]), oz);
    const F squared = add(add(mul(x, x), mul(y, y)), mul(z, z));
    const M met = static_cast<M>(lessEqual(squared, squared_reach) & asked);
    if (met == 0) continue;
    hits |= std::uint64_t{met} << first;
    if (sums == nullptr) continue;
    const F overlap = choose(met, sub(reach, root(squared)), all(0.0F));
    const auto gain = [&](int i, F value) HD_LANES_LAMBDA { store(sums->sum[i], add(load(sums->sum[i]), value)); };
    gain(0, overlap);
    gain(1, mul(overlap, add(all(at[0]), mul(follow, ox))));
    gain(2, mul(overlap, add(all(at[1]), mul(follow, oy))));
    gain(3, mul(overlap, add(all(at[2]), mul(follow, oz))));
  }
  return hits;
}

void reduceBalls(const BallSums& sums, float* out) noexcept {
  for (int i = 0; i < 4; ++i) out[i] = sumOf(load(sums.sum[i]));
}

std::uint64_t near(const SphereTable& spheres, std::uint32_t count, const float (&centre)[3], float radius) noexcept {
  std::uint64_t hits = 0;
  for (std::uint32_t first = 0; first < count; first += 16) {
    const F x = sub(load(spheres.x + first), all(centre[0])), y = sub(load(spheres.y + first), all(centre[1])),
            z = sub(load(spheres.z + first), all(centre[2])), reach = add(load(spheres.r + first), all(radius));
    const M met = lessEqual(add(add(mul(x, x), mul(y, y)), mul(z, z)), mul(reach, reach));
    hits |= std::uint64_t{met} << first;
  }
  return count < 64 ? hits & ((std::uint64_t{1} << count) - 1) : hits;
}

/** Lanes of a layer of the window about a voxel: y runs fastest, as in the rows that are loaded together. */
constexpr float kAlongX[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
constexpr float kAlongY[16] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
constexpr float kBitsAlongX[16] = {1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4, 8, 8, 8, 8};

void meetWindow(const VoxelWindow& window, std::uint32_t count, bool first_only, WindowSums& sums) noexcept {
  const F reach = all(window.reach), squared_reach = all(window.reach * window.reach), zero = zeroOf();
  const F along_x = load(kAlongX), along_y = load(kAlongY);
  const I bits_along_x = toInt(load(kBitsAlongX));
  F overlap = load(sums.balls.sum[0]), mean_x = load(sums.balls.sum[1]), mean_y = load(sums.balls.sum[2]),
    mean_z = load(sums.balls.sum[3]);
  for (std::uint32_t block = 0; block < count; block += 16) {
    // Sixteen voxels' windows at once: their lower corners, how far the voxel is from the first centre on each axis.
    const F px = load(window.x + block), py = load(window.y + block), pz = load(window.z + block);
    const F before = all(1.5F), half = all(0.5F);
    const I cx = toInt(sub(px, before)), cy = toInt(sub(py, before)), cz = toInt(sub(pz, before));
    Lanes16 column, row;
    alignas(64) float fx[16], fy[16], layer[4][16];
    keep(column, cx);
    keep(row, addInt(cy, mulInt(cz, allInt(static_cast<std::int32_t>(kWindow)))));
    store(fx, sub(px, add(toFloat(cx), half)));
    store(fy, sub(py, add(toFloat(cy), half)));
    const F fz = sub(pz, add(toFloat(cz), half));
    for (int k = 0; k < 4; ++k) {
      const F z = sub(all(static_cast<float>(k)), fz);
      store(layer[k], mul(z, z));
    }
    const std::uint32_t here = count - block < 16 ? count - block : 16;
    for (std::uint32_t i = 0; i < here; ++i) {
      const I bit = shiftedLeft(bits_along_x, column.i[i]);
      const std::uint32_t* rows = window.row + row.i[i];
      const F x = sub(along_x, all(fx[i])), y = sub(along_y, all(fy[i]));
      const F across = add(mul(x, x), mul(y, y));
      // Layer by layer, none in an array: sixteen bits written and sixty-four read would wait for each other.
      const auto squared = [&](int k) HD_LANES_LAMBDA { return add(across, all(layer[k][i])); };
      const F s0 = squared(0), s1 = squared(1), s2 = squared(2), s3 = squared(3);
      const auto meets = [&](int k, F s) HD_LANES_LAMBDA {
        return static_cast<M>(hasBit(rows + kWindow * k, bit) & lessEqual(s, squared_reach));
      };
      const M m0 = meets(0, s0), m1 = meets(1, s1), m2 = meets(2, s2), m3 = meets(3, s3);
      const std::uint64_t any = (m0 | std::uint64_t{m1} << 16) | (std::uint64_t{m2} << 32 | std::uint64_t{m3} << 48);
      if (any == 0) continue;
      const auto part = [&](M m, F s) HD_LANES_LAMBDA { return choose(m, sub(reach, root(s)), zero); };
      const F own = add(add(part(m0, s0), part(m1, s1)), add(part(m2, s2), part(m3, s3)));
      sums.pairs += static_cast<std::uint32_t>(__builtin_popcountll(any));
      ++sums.voxels;
      overlap = add(overlap, own);
      mean_x = add(mean_x, mul(own, all(window.x[block + i])));
      mean_y = add(mean_y, mul(own, all(window.y[block + i])));
      mean_z = add(mean_z, mul(own, all(window.z[block + i])));
      if (!first_only) continue;
      block = count;
      break;
    }
  }
  store(sums.balls.sum[0], overlap);
  store(sums.balls.sum[1], mean_x);
  store(sums.balls.sum[2], mean_y);
  store(sums.balls.sum[3], mean_z);
}

}  // namespace
}  // namespace hapticd
