// Descriptors of force-feedback devices: whatever is accepted, the reports stay in their bounds.
#include <cstdint>
#include <cstdlib>

#include "drivers/hidpid/pid_reports.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  const Result<HidReports> reports = HidReports::parse({data, size});
  if (!reports.ok()) return 0;
  const Result<pid::Layout> layout = pid::layoutOf(*reports);
  if (!layout.ok()) {
    if (layout.error().what.empty()) std::abort();
    return 0;
  }
  const Result<pid::Lengths> lengths = pid::lengthsOf(*reports, layout.value());
  if (!lengths.ok()) return 0;
  const pid::Encoder encoder(layout.value(), lengths.value());
  for (std::size_t axis = 0; axis < layout.value().axes; ++axis) {
    for (const auto effect : {pid::Effect::kConstant, pid::Effect::kSpring, pid::Effect::kDamper}) {
      if (encoder.effect({effect, axis, 100, 1}).bytes().size() > pid::Report::kLongest) std::abort();
      (void)encoder.create(effect);
    }
    (void)encoder.condition({1, axis, -0.5, 0.2, 0.2});
  }
  (void)encoder.constant(1, -0.7);
  (void)encoder.start(1);
  (void)encoder.stop(1);
  (void)encoder.fullGain();
  (void)encoder.load();
  return 0;
}
