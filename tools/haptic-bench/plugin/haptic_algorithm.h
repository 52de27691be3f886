/** @file
 * A rendering algorithm as haptic-bench sees it: a table of functions. Those in the box use it in-process; others come
 * as a shared object that exports haptic_algorithm_table(). This header needs nothing but the standard library.
 *
 * For each round haptic-bench makes an instance with create(), calls start() once, then step() for every sample from
 * one thread, and at the end destroy(). Where several algorithms are to run, one more instance of each is made and
 * destroyed before, to see whether it refuses.
 *
 * SI units; right-handed axes; forces act on the hand. No function may throw or exit.
 */
#ifndef HAPTIC_ALGORITHM_H
#define HAPTIC_ALGORITHM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Of everything below. haptic-bench refuses a table of another version. */
#define HAPTIC_ALGORITHM_VERSION 1u

/** What is to be touched. The arrays are valid until create() returns. */
typedef struct haptic_algorithm_problem {
  const float (*vertices)[3];     /**< [m] */
  const uint32_t (*triangles)[3]; /**< Indices, counter-clockwise seen from outside. */
  uint32_t vertex_count;
  uint32_t triangle_count;
  double stiffness;       /**< [N/m] */
  double damping;         /**< Along the normal, of the surface [N s/m]. */
  double friction_static; /**< Coefficients of friction; both 0 without it. */
  double friction_dynamic;
  double radius;       /**< Of the ball that touches, about the hand's point; 0: a point [m]. Refuse what you cannot. */
  double period_s;     /**< Of most samples. */
  const char* options; /**< What stood behind the colon of --algorithm NAME:OPTIONS; "" if nothing did. */
} haptic_algorithm_problem;

/** What a step answers. */
typedef struct haptic_algorithm_contact {
  double force[3];  /**< On the hand [N]. */
  double proxy[3];  /**< The point on the surface, or the ball's centre; the hand's point in free space [m]. */
  uint32_t touches; /**< 1 in contact, 0 in free space. */
  uint32_t reserved;
} haptic_algorithm_contact;

typedef struct haptic_algorithm {
  uint32_t version; /**< HAPTIC_ALGORITHM_VERSION */
  uint32_t bytes;   /**< sizeof(haptic_algorithm) */
  const char* name;
  const char* summary; /**< One line. */
  /** An instance; null with a sentence in `error` (at most error_bytes with its zero) when the problem is refused. */
  void* (*create)(const haptic_algorithm_problem* problem, char* error, size_t error_bytes);
  void (*destroy)(void* instance);
  /** A run begins with the hand at `hip`, in free space. */
  void (*start)(void* instance, const double hip[3]);
  /** The hand is at `hip` [m] with `velocity` [m/s]; dt_s since the last step. This is what is timed. */
  void (*step)(void* instance, const double hip[3], const double velocity[3], double dt_s,
               haptic_algorithm_contact* contact);
  /** Memory the instance holds; the function may be null where nobody knows. */
  uint64_t (*memory_bytes)(void* instance);
} haptic_algorithm;

/** The name of the one function a shared object exports. */
#define HAPTIC_ALGORITHM_SYMBOL "haptic_algorithm_table"
/** Static storage; never null. */
const haptic_algorithm* haptic_algorithm_table(void);

#ifdef __cplusplus
}
#endif

#endif /* HAPTIC_ALGORITHM_H */
