/* The headers as a C11 program sees them. */
#include <hapticclient/hapticclient.h>

int hapticHeaderInC(void);
int hapticHeaderInC(void) {
  haptic_error error = HAPTIC_ERROR_INIT;
  const haptic_connect_options connect = HAPTIC_CONNECT_OPTIONS_INIT;
  const haptic_session_options session = HAPTIC_SESSION_OPTIONS_INIT;
  const haptic_events_options events = HAPTIC_EVENTS_OPTIONS_INIT;
  const haptic_object object = HAPTIC_OBJECT_INIT;
  const haptic_event event = HAPTIC_EVENT_INIT;
  const haptic_session_limits limits = HAPTIC_SESSION_LIMITS_INIT;
  if (event.size != sizeof event || limits.force_n != 1000 || limits.torque_nm != 100) return 0;
  return error.size == sizeof error && connect.size == sizeof connect && session.size == sizeof session &&
         events.size == sizeof events && object.size == sizeof object && object.material.stiffness == 1000 &&
         object.pose.q[0] == 1;
}
