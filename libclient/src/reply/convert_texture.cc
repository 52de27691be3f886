#include <string_view>

#include "libclient/src/reply/convert.h"

namespace hapticd::client {

haptic_surface* convert(proto::Surface::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_surface>();
  to->smooth_deg = from.getSmoothDeg();
  to->transient_gain = from.getTransientGain();
  to->transient_hz = from.getTransientHz();
  to->transient_decay_s = from.getTransientDecay();
  to->relief = from.getRelief();
  to->relief_depth = from.getReliefDepth();
  to->relief_width = from.getReliefWidth();
  to->relief_height = from.getReliefHeight();
  to->vibration = from.getVibration();
  to->vibration_mass = from.getVibrationMass();
  return to;
}

haptic_texture_report* convert(proto::TextureReport::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_texture_report>();
  to->relief = from.getRelief();
  to->id = from.getId();
  to->width = from.getWidth();
  to->height = from.getHeight();
  to->models = from.getModels();
  to->uses = from.getUses();
  to->rate_hz = from.getRate();
  to->bytes = from.getBytes();
  to->owner = reply.text(std::string_view(from.getOwner().cStr(), from.getOwner().size()));
  return to;
}

haptic_texture_list* convert(capnp::List<proto::TextureReport>::Reader from, Reply& reply) {
  auto* to = reply.make<haptic_texture_list>();
  to->count = from.size();
  auto** items = reply.makeArray<const haptic_texture_report*>(to->count);
  for (std::uint32_t i = 0; i < to->count; ++i) items[i] = convert(from[i], reply);
  to->items = items;
  return to;
}

void fill(const haptic_surface& from, proto::Surface::Builder to) {
  to.setSmoothDeg(from.smooth_deg);
  to.setTransientGain(from.transient_gain);
  to.setTransientHz(from.transient_hz);
  to.setTransientDecay(from.transient_decay_s);
  to.setRelief(from.relief);
  to.setReliefDepth(from.relief_depth);
  to.setReliefWidth(from.relief_width);
  to.setReliefHeight(from.relief_height);
  to.setVibration(from.vibration);
  to.setVibrationMass(from.vibration_mass);
}

}  // namespace hapticd::client
