/** @file
 * What an object does to a hand in free space: guides, magnets, drag, pushes and buzzes.
 */
#ifndef HAPTICCLIENT_EFFECT_H
#define HAPTICCLIENT_EFFECT_H

#include <hapticclient/client.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum haptic_effect_kind {
  HAPTIC_EFFECT_NONE = 0,      /**< Nothing. */
  HAPTIC_EFFECT_FORCE = 1,     /**< `force` along the object's z. */
  HAPTIC_EFFECT_VISCOUS = 2,   /**< Drag by `damping`, at most `force`. */
  HAPTIC_EFFECT_FRICTION = 3,  /**< Sticks with `stiffness` until `force`, then slides. */
  HAPTIC_EFFECT_VIBRATION = 4, /**< `force` swings at `hz` along the object's z. */
  HAPTIC_EFFECT_GUIDE = 5      /**< Draws to the path, the shape or the origin with `stiffness`, at most `force`. */
} haptic_effect_kind;

/** Set it by haptic_object_set_effect(); docs/effects.md tells the laws. */
typedef struct haptic_effect {
  uint32_t size;
  uint32_t kind;       /**< haptic_effect_kind */
  double force;        /**< The most it pushes, 0 to 1000 [N]. */
  double stiffness;    /**< Of a guide, and of friction that sticks, 0 to 100000 [N/m]. */
  double damping;      /**< Of viscous, and of a guide across its way, 0 to 1000 [N s/m]. */
  double reach;        /**< Beyond this distance there is nothing, 0.001 to 100 [m]. */
  double hz;           /**< Of a vibration, 0 to 400. */
  double duration_s;   /**< It ends so long after it was set, 0 to 3600; 0: it does not. */
  const double* path;  /**< A smooth curve through x, y, z, ... in the object's frame [m]; null: the object itself. */
  uint32_t path_count; /**< Its points: 0, or 2 to 32. */
  uint32_t reserved;
} haptic_effect;

/** None yet; what you turn on is moderate. */
#define HAPTIC_EFFECT_INIT \
  { sizeof(haptic_effect), HAPTIC_EFFECT_NONE, 1, 200, 2, 0.02, 100, 0, NULL, 0, 0 }

/**
 * All of `effect` at once, or nothing: HAPTIC_INVALID_ARGUMENT names the field, HAPTIC_QUOTA_EXCEEDED: 16 other objects
 * have one. It goes where the object goes and ends with it. Blocks; any thread.
 */
HAPTIC_API int haptic_object_set_effect(haptic_client* client, const char* name, const haptic_effect* effect,
                                        haptic_error* error);

#ifdef __cplusplus
}
#endif

#endif
