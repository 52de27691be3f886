// Report descriptors of whatever is plugged in: what is accepted lies within its reports, and numbers go in and out.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "drivers/hid/report_descriptor.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  const Result<HidReports> reports = HidReports::parse({data, size});
  if (!reports.ok()) {
    if (reports.error().what.empty() || reports.error().where.empty()) std::abort();
    return 0;
  }
  if (reports->fields().size() > HidReports::kMostFields) std::abort();
  for (const HidField& field : reports->fields()) {
    const std::size_t bytes = reports->reportBytes(field.kind, field.report_id);
    std::vector<std::uint8_t> report(bytes - (reports->numbered() ? 1 : 0), 0xa5);
    if (field.bit_offset + field.bits > 8 * report.size()) std::abort();
    insert(field, field.logical_max, report);
    const std::int32_t back = extract(field, report);
    const std::int64_t top = (std::int64_t{1} << (field.bits - (field.logical_min < 0 ? 1 : 0))) - 1;
    if (field.logical_max <= top && field.logical_min >= -top && back != field.logical_max) std::abort();
    (void)reports->isWithin(field, field.usage);
  }
  return 0;
}
