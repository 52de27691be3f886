/** @file
 * The error list: every refusal that crosses a process boundary, by name and number.
 *
 * Numbers never change meaning and are never reused. A code says what kind of refusal it is; the text that travels with
 * it says where (file, line, field, index) and what to do about it.
 */
#ifndef HAPTICD_PROTO_ERRORS_H
#define HAPTICD_PROTO_ERRORS_H

/** X(name in C, name in C++, number, one sentence). 9 was given for nothing and is nobody's. */
#define HAPTIC_ERROR_LIST(X)                                                                        \
  X(OK, kOk, 0, "no error")                                                                         \
  X(INVALID_ARGUMENT, kInvalidArgument, 1, "a value is malformed, not finite or out of range")      \
  X(NOT_FOUND, kNotFound, 2, "no object, device, mesh or path of that name")                        \
  X(ALREADY_EXISTS, kAlreadyExists, 3, "the name is taken")                                         \
  X(PERMISSION_DENIED, kPermissionDenied, 4, "the caller may not do this on this socket")           \
  X(QUOTA_EXCEEDED, kQuotaExceeded, 5, "a quota of the user, or what there is for all, is used up") \
  X(VERSION_MISMATCH, kVersionMismatch, 6, "client and daemon speak different versions")            \
  X(LEASE_REQUIRED, kLeaseRequired, 7, "only the holder of the device lease may do this")           \
  X(LEASE_HELD, kLeaseHeld, 8, "another client holds the device lease")                             \
  X(FAULT_LATCHED, kFaultLatched, 10, "a fault is latched; clear its cause and arm again")          \
  X(DEVICE_GONE, kDeviceGone, 11, "the device is unplugged or does not answer")                     \
  X(DEVICE_BUSY, kDeviceBusy, 12, "another program or driver owns the device")                      \
  X(STILL_MAPPED, kStillMapped, 13, "the upload is still mapped writable; unmap it before commit")  \
  X(BAD_MESH, kBadMesh, 14, "the mesh cannot be rendered as it is")                                 \
  X(BAD_SNAPSHOT, kBadSnapshot, 15, "a built model is damaged or of another version")               \
  X(BUILDER_FAILED, kBuilderFailed, 16, "the builder process crashed or ran out of memory")         \
  X(WOULD_BLOCK, kWouldBlock, 17, "not now: a queue is full, or nothing is there yet; try again")   \
  X(DISCONNECTED, kDisconnected, 18, "the daemon is not there or has restarted")                    \
  X(NO_REALTIME, kNoRealtime, 19, "real-time rights are missing")                                   \
  X(SYSTEM, kSystem, 20, "the operating system refused")                                            \
  X(UNSUPPORTED, kUnsupported, 21, "this device or build cannot do that")                           \
  X(TIMEOUT, kTimeout, 22, "no answer in time")                                                     \
  X(CANCELLED, kCancelled, 23, "cancelled by the caller")                                           \
  X(INTERNAL, kInternal, 24, "a defect in hapticd; please report it")

#endif  // HAPTICD_PROTO_ERRORS_H
