/* An algorithm as a plug-in, to start from: the facet whose centre is nearest to the hand pushes along its normal.
 * Cheap, jumpy at edges, and exact on a plane.
 *
 *     cc -shared -fPIC -o facet.so example.c -lm
 *     haptic-bench run -a ours ./facet.so
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "haptic_algorithm.h"

typedef struct facet {
  double centre[3], normal[3];
} facet;

typedef struct facets {
  double stiffness;
  uint32_t count;
  facet facet[];
} facets;

static double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void* create(const haptic_algorithm_problem* problem, char* error, size_t error_bytes) {
  if (problem->options[0] != 0) return snprintf(error, error_bytes, "it takes no options"), NULL;
  facets* all = malloc(sizeof *all + problem->triangle_count * sizeof all->facet[0]);
  if (all == NULL) return snprintf(error, error_bytes, "no memory for %u facets", problem->triangle_count), NULL;
  all->stiffness = problem->stiffness;
  all->count = problem->triangle_count;
  for (uint32_t t = 0; t < all->count; ++t) {
    const uint32_t* v = problem->triangles[t];
    const float *a = problem->vertices[v[0]], *b = problem->vertices[v[1]], *c = problem->vertices[v[2]];
    const double ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, ac[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const double n[3] = {ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]};
    const double length = sqrt(dot(n, n));
    for (int i = 0; i < 3; ++i) {
      all->facet[t].centre[i] = ((double)a[i] + b[i] + c[i]) / 3;
      all->facet[t].normal[i] = length > 0 ? n[i] / length : 0;
    }
  }
  return all;
}

static void destroy(void* instance) { free(instance); }

static void start(void* instance, const double hip[3]) { (void)instance, (void)hip; } /* It remembers nothing. */

static void step(void* instance, const double hip[3], const double velocity[3], double dt_s,
                 haptic_algorithm_contact* contact) {
  (void)velocity, (void)dt_s;
  const facets* all = instance;
  double nearest = INFINITY, depth = 0;
  const double* normal = hip;
  for (uint32_t t = 0; t < all->count; ++t) {
    const facet* f = &all->facet[t];
    const double to[3] = {f->centre[0] - hip[0], f->centre[1] - hip[1], f->centre[2] - hip[2]};
    if (dot(to, to) >= nearest) continue;
    nearest = dot(to, to);
    depth = dot(to, f->normal);
    normal = f->normal;
  }
  contact->touches = depth > 0;
  if (depth < 0) depth = 0;
  for (int i = 0; i < 3; ++i) {
    contact->force[i] = all->stiffness * depth * normal[i];
    contact->proxy[i] = hip[i] + depth * normal[i];
  }
}

static uint64_t memory_bytes(void* instance) {
  const facets* all = instance;
  return sizeof *all + all->count * sizeof all->facet[0];
}

const haptic_algorithm* haptic_algorithm_table(void) {
  static const haptic_algorithm table = {HAPTIC_ALGORITHM_VERSION,
                                         sizeof(haptic_algorithm),
                                         "facet",
                                         "the facet with the nearest centre",
                                         create,
                                         destroy,
                                         start,
                                         step,
                                         memory_bytes};
  return &table;
}
