/** @file
 * The mark of functions that the servo, collide and ingest threads may call.
 *
 * HD_RT promises: never allocates, locks, faults, throws, logs nor enters the kernel, and every loop is bounded. The
 * detectors of tests/rt prove it by running the cycle under them; the mark is for readers and for grep.
 */
#pragma once

#if defined(__clang__) && __clang_major__ >= 20
#define HD_RT noexcept [[clang::nonblocking]]
#else
#define HD_RT noexcept
#endif
