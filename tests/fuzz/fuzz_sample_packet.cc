// Packets of the sample device: only whole ones are read.
#include <cstdint>
#include <cstdlib>

#include "drivers/sample/sample_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd::sample;
  const auto reading = decode({data, size});
  if (reading && (size != kBytes || crc16({data, size - 2}) != (data[10] | data[11] << 8))) std::abort();
  return 0;
}
