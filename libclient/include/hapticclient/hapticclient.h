/** @file
 * libhapticclient: touch for C programs. This header brings all of it.
 *
 *     haptic_client* client; haptic_session* session; haptic_sample sample;
 *     haptic_error error = HAPTIC_ERROR_INIT;
 *     if (haptic_connect(NULL, &client, &error) || haptic_session_open(client, NULL, &session, &error))
 *       return fprintf(stderr, "%s: %s (%s)\n", error.where, error.what, error.remedy), 1;
 *     if (haptic_session_latest(session, &sample) == HAPTIC_OK) printf("%g m\n", sample.p[2]);
 *     haptic_session_close(session); haptic_disconnect(client);
 *
 * World frame: right-handed, x toward the operator, y to the operator's right, z up; SI units; quaternions w, x, y, z;
 * times are CLOCK_MONOTONIC nanoseconds. Other axes: frames.h.
 *
 * A call is haptic_<thing>_<what it does or gives>: haptic_session_arm(), haptic_object_volume_file(). What sends or
 * converts is haptic_push_<what>, on a session, haptic_upload_<what>, haptic_convert_<what>. The others are about the
 * connection, the daemon with its devices or the library: haptic_connect(), haptic_stop(), haptic_version().
 *
 * - base.h     errors, ownership, common types
 * - client.h   the connection, resources by name
 * - device.h   devices, limits, stop
 * - status.h   status, statistics, checks
 * - session.h  a session with a device: state, lease, arming
 * - push.h     what is sent at the client's pace: motion, local models, forces
 * - scene.h    objects and meshes
 * - effect.h   what objects do to a hand in free space
 * - record.h   recordings of all that a servo did
 * - texture.h  what a surface feels like beyond its material
 * - events.h   touches, faults, leases
 * - frames.h   axes of OpenGL, ROS and Haply
 */
#ifndef HAPTICCLIENT_H
#define HAPTICCLIENT_H

#include <hapticclient/base.h>
#include <hapticclient/client.h>
#include <hapticclient/device.h>
#include <hapticclient/effect.h>
#include <hapticclient/events.h>
#include <hapticclient/frames.h>
#include <hapticclient/push.h>
#include <hapticclient/record.h>
#include <hapticclient/scene.h>
#include <hapticclient/session.h>
#include <hapticclient/status.h>
#include <hapticclient/texture.h>

#endif /* HAPTICCLIENT_H */
