/** @file
 * Marching tetrahedra in one lattice cell: which edges a surface cuts, and its triangles between them.
 *
 * Corners are numbered x + 2 y + 4 z. The six tetrahedra are Kuhn's: cells side by side cut their common face in the
 * same way, so what is drawn is closed and 2-manifold whatever the values are.
 */
#pragma once

namespace hapticd {

/** Each on a way from corner 0 to corner 7 along the axes. */
inline constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7},
                                          {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}};

/** An edge of a cell that the surface cuts: from a corner inside to one outside. */
struct CutEdge {
  int in, out_of;
};

/**
 * Calls add(a, b, c) for each triangle of the surface, with what cut(in, out_of) gave for its edges. `inside`: bit c
 * for corner c. The triangles look either way, see looksOut().
 */
template <class MakeCut, class Add>
void marchCell(unsigned inside, MakeCut&& cut, Add&& add) {
  for (const auto& t : kTetrahedra) {
    int in[4], out_of[4], n_in = 0, n_out = 0;
    for (const int c : t) (inside >> c & 1) != 0 ? in[n_in++] = c : out_of[n_out++] = c;
    if (n_in == 0 || n_out == 0) continue;
    if (n_in == 1) {
      add(cut(in[0], out_of[0]), cut(in[0], out_of[1]), cut(in[0], out_of[2]));
    } else if (n_in == 3) {
      add(cut(in[0], out_of[0]), cut(in[1], out_of[0]), cut(in[2], out_of[0]));
    } else {
      const auto a = cut(in[0], out_of[0]), b = cut(in[0], out_of[1]), c = cut(in[1], out_of[1]),
                 d = cut(in[1], out_of[0]);
      add(a, b, c);
      add(a, c, d);
    }
  }
}

/** Whether a triangle of marchCell() looks from inside to outside, counterclockwise: told by its edges' middles. */
[[nodiscard]] constexpr bool looksOut(const CutEdge& a, const CutEdge& b, const CutEdge& c) {
  int u[3] = {}, w[3] = {}, out[3] = {};
  for (int k = 0; k < 3; ++k) {
    const auto twice = [k](const CutEdge& cut) { return (cut.in >> k & 1) + (cut.out_of >> k & 1); };
    u[k] = twice(b) - twice(a);
    w[k] = twice(c) - twice(a);
    out[k] = (a.out_of >> k & 1) - (a.in >> k & 1);
  }
  return (u[1] * w[2] - u[2] * w[1]) * out[0] + (u[2] * w[0] - u[0] * w[2]) * out[1] +
             (u[0] * w[1] - u[1] * w[0]) * out[2] >
         0;
}

}  // namespace hapticd
