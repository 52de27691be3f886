/** @file
 * Before any header of ITK: Debian's knows only the compiler it was built with, g++, and refuses clang, of which it
 * would ask the same.
 */
#pragma once

#ifdef __clang__
#define ITK_COMPILER_DETECTION_H
#define ITK_ALIGNAS(X) alignas(X)
#define ITK_NOEXCEPT noexcept
#define ITK_THREAD_LOCAL thread_local
#define ITK_FALLTHROUGH [[fallthrough]]
#endif
