/** @file
 * What a client fills to upload a texture: a relief as a grey image, or vibrations as a table of autoregressive models.
 * Both cross as sealed memfds like meshes (snapshot.h); little-endian, tightly packed, nothing of it trusted.
 */
#ifndef HAPTICD_PROTO_TEXTURE_H
#define HAPTICD_PROTO_TEXTURE_H

#include <stdint.h>

#define HD_TEXTURE_MAGIC UINT64_C(0x3158455454504148) /**< "HAPTTEX1" */

#define HD_RELIEF_LEAST_SIDE 2u
#define HD_RELIEF_MOST_SIDE 4096u
#define HD_VIBRATION_MOST_MODELS 256u
#define HD_VIBRATION_MOST_TRIANGLES 512u
#define HD_VIBRATION_MOST_ORDER 32u /**< Coefficients of one model, the leading 1 not counted. */
#define HD_VIBRATION_LEAST_RATE 100.0
#define HD_VIBRATION_MOST_RATE 100000.0

enum hd_texture_kind { HD_TEXTURE_RELIEF = 1, HD_TEXTURE_VIBRATION = 2 };

/** Start of every texture. */
struct hd_texture_upload {
  uint64_t magic;
  uint32_t kind;     /**< hd_texture_kind */
  uint32_t reserved; /**< 0 */
};

/** Height by grey: 65535 is the surface itself, 0 the deepest. The first row is the upper edge of the picture. */
struct hd_relief_upload {
  struct hd_texture_upload head;
  uint32_t width;
  uint32_t height;
  /* uint16_t pixel[height][width]; */
};

/**
 * Acceleration felt through a tool at some speeds and forces: y[n] = e[n] - a1 y[n-1] - ... - ap y[n-p] with white
 * noise e of the given variance. Between the models, triangles over the plane of speed and force (a Delaunay
 * triangulation).
 */
struct hd_vibration_upload {
  struct hd_texture_upload head;
  uint32_t models;
  uint32_t triangles;
  uint32_t order;
  uint32_t reserved;
  double rate_hz; /**< Of the models. */
  /* struct hd_vibration_model model[models], each followed by double a[order];
     uint32_t triangle[triangles][3]: indices of models, from 0. */
};

struct hd_vibration_model {
  double speed;    /**< Of the tool over the surface [m/s]. */
  double force;    /**< Normal [N]. */
  double variance; /**< Of the noise [m^2/s^4]. */
};

#endif /* HAPTICD_PROTO_TEXTURE_H */
