/** @file
 * What daemon and hapticd-vendor say to each other over their socket: one request with the shared memory attached, one
 * answer. After that the socket only tells each that the other lives.
 */
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "rt/base/error.h"
#include "rt/device.h"

namespace hapticd {

inline constexpr std::size_t kMostHelperUri = 4096;
inline constexpr std::uint32_t kHelperProtocol = 1;

/** Drive this device over that memory. */
struct HelperRequest {
  std::string uri;
  std::uint32_t generation = 0;
};
/** Device is open, or why not. */
struct HelperAnswer {
  Result<void> opened;
  DeviceInfo info;  ///< When it is.
};

/** What the bytes of a message say. Pure; fuzzed. Errors as below. */
[[nodiscard]] Result<HelperRequest> decodeRequest(std::span<const std::uint8_t> bytes);
[[nodiscard]] Result<HelperAnswer> decodeAnswer(std::span<const std::uint8_t> bytes);

/** One message each; the memory's descriptor goes along and stays the caller's. */
[[nodiscard]] Result<void> sendRequest(int socket, const HelperRequest& request, int memory);
/** `memory` is the caller's to close. kVersionMismatch from another build. */
[[nodiscard]] Result<HelperRequest> receiveRequest(int socket, int& memory);
[[nodiscard]] Result<void> sendAnswer(int socket, const HelperAnswer& answer);
/** kTimeout after `wait_ms`; kDeviceGone when the other side hangs up first. Texts come out printable, numbers finite.
 */
[[nodiscard]] Result<HelperAnswer> receiveAnswer(int socket, int wait_ms);

}  // namespace hapticd
