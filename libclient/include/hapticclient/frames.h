/** @file
 * Axes of other systems. All are right-handed; conversions only permute and negate, so they are exact.
 *
 * | frame                            | toward the operator | operator's right | up |
 * |----------------------------------|---------------------|------------------|----|
 * | hapticd, CHAI3D, Force Dimension | +x                  | +y               | +z |
 * | OpenGL, OpenHaptics, H3D, X3D    | +z                  | +x               | +y |
 * | ROS (REP-103)                    | -x                  | -y               | +z |
 * | Haply Inverse                    | -y                  | +x               | +z |
 *
 * Units do not change: metres stay metres (OpenHaptics itself counts in millimetres). Any thread, servo-safe; in and
 * out may be the same array. HAPTIC_INVALID_ARGUMENT for a frame that is not in the list.
 */
#ifndef HAPTICCLIENT_FRAMES_H
#define HAPTICCLIENT_FRAMES_H

#include <hapticclient/base.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum haptic_frame {
  HAPTIC_FRAME_HAPTICD = 0, /**< Also CHAI3D and Force Dimension. */
  HAPTIC_FRAME_OPENGL = 1,  /**< Also OpenHaptics, H3D and X3D. */
  HAPTIC_FRAME_ROS = 2,     /**< REP-103: x forward, y left, z up; forward is away from the operator. */
  HAPTIC_FRAME_HAPLY = 3
} haptic_frame;

/** Positions, directions, velocities, forces, torques. `from`, `to`: haptic_frame; HAPTIC_INVALID_ARGUMENT for others.
 */
HAPTIC_API int haptic_convert_vector(uint32_t from, uint32_t to, const double in[3], double out[3]);
/** Orientations w, x, y, z (ROS messages keep w last). The body's own axes are renamed as the world's are. */
HAPTIC_API int haptic_convert_quaternion(uint32_t from, uint32_t to, const double in[4], double out[4]);
/** 3x3 row-major matrices that map vectors to vectors: rotations, and Jacobians of force by position. */
HAPTIC_API int haptic_convert_matrix(uint32_t from, uint32_t to, const double in[9], double out[9]);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_FRAMES_H */
