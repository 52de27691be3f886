/** @file
 * What a surface feels like beyond its material: shading, transients of impacts, reliefs and vibrations.
 */
#ifndef HAPTICCLIENT_TEXTURE_H
#define HAPTICCLIENT_TEXTURE_H

#include <hapticclient/client.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Set it by haptic_object_set_surface(); docs/surfaces.md tells what each number is felt as. */
typedef struct haptic_surface {
  uint32_t size;
  uint32_t reserved;
  double smooth_deg;        /**< Edges of a mesh that bend less are shaded round [degree]; 0: none is. */
  double transient_gain;    /**< Force per speed of impact [N s/m]; 0: none. */
  double transient_hz;      /**< What an impact rings at, 10 to 400. */
  double transient_decay_s; /**< Time to 1/e, 0.001 to 0.2. */
  uint64_t relief;          /**< Texture, 0 for none. */
  double relief_depth;      /**< From white down to black [m]. */
  double relief_width;      /**< Of the picture [m]. */
  double relief_height;     /**< [m] */
  uint64_t vibration;       /**< Texture, 0 for none. */
  double vibration_mass;    /**< Force per acceleration [kg]. */
} haptic_surface;

/** A plain surface; what you turn on is moderate. */
#define HAPTIC_SURFACE_INIT \
  { sizeof(haptic_surface), 0, 0, 0, 150, 0.01, 0, 0.0002, 0.1, 0.1, 0, 0.05 }

/** A texture that the daemon holds. */
typedef struct haptic_texture_report {
  uint32_t size;
  uint32_t relief; /**< 1: a relief, 0: a vibration. */
  uint64_t id;     /**< For haptic_surface.relief or .vibration. */
  uint32_t width;  /**< Of a relief, pixels. */
  uint32_t height;
  uint32_t models; /**< Of a vibration. */
  uint32_t uses;   /**< Surfaces that show it. */
  double rate_hz;  /**< A vibration was recorded at. */
  uint64_t bytes;  /**< Of each copy: one for the servos of a rate. */
  const char* owner;
} haptic_texture_report;

typedef struct haptic_texture_list {
  uint32_t size;
  uint32_t count;
  const haptic_texture_report* const* items;
} haptic_texture_list;

/** Acceleration at one speed and force: y[n] = e[n] - a[0] y[n-1] - ... with white noise e. */
typedef struct haptic_vibration_model {
  double speed;    /**< Of the tool over the surface [m/s]. */
  double force;    /**< Normal [N]. */
  double variance; /**< Of e [m^2/s^4]. */
  const double* a; /**< haptic_vibration.order coefficients. */
} haptic_vibration_model;

/** Recorded vibration: models and, between them, triangles over the plane of speed and force. */
typedef struct haptic_vibration {
  uint32_t size;
  uint32_t order;          /**< 1 to 32. */
  double rate_hz;          /**< Of the models. */
  uint32_t model_count;    /**< 3 to 256. */
  uint32_t triangle_count; /**< 1 to 512. */
  const haptic_vibration_model* models;
  const uint32_t* triangles; /**< Three indices of models each, from 0. */
} haptic_vibration;

/** All of `surface` at once. Blocks; any thread, as all here. */
HAPTIC_API int haptic_object_set_surface(haptic_client* client, const char* name, const haptic_surface* surface,
                                         haptic_error* error);
/**
 * A relief from a grey picture, row by row from its upper edge: 65535 is the surface itself, 0 the deepest. 2 to 4096
 * pixels a side.
 */
HAPTIC_API int haptic_upload_relief(haptic_client* client, const uint16_t* grey, uint32_t width, uint32_t height,
                                    haptic_texture_report** report, haptic_error* error);
/** The daemon resamples the models to its own rate; an unstable one is refused by its number. */
HAPTIC_API int haptic_upload_vibration(haptic_client* client, const haptic_vibration* vibration,
                                       haptic_texture_report** report, haptic_error* error);
/** All textures, whoever uploaded them. */
HAPTIC_API int haptic_texture_list_all(haptic_client* client, haptic_texture_list** textures, haptic_error* error);
/** Refused while a surface shows it. It goes by itself with the client that made it, once unused. */
HAPTIC_API int haptic_texture_drop(haptic_client* client, uint64_t texture, haptic_error* error);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_TEXTURE_H */
