"""What the tests of the Python module wait with."""
import time

import hapticclient as haptic


def eventually(condition, seconds=60.0):
    """Whether it comes true in that time. What is not made yet is asked for again."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            if condition():
                return True
        except haptic.HapticError as error:
            if error.code != haptic.Code.WOULD_BLOCK:
                raise
        time.sleep(0.005)
    return False


def armed(session):
    """Whether all of the force reaches the device: the ramp is over."""
    on, ramping = haptic.SampleFlag.ARMED, haptic.SampleFlag.RAMPING
    return session.latest()["flags"] & (on | ramping) == on
