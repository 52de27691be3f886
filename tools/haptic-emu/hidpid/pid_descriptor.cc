#include "tools/haptic-emu/hidpid/pid_descriptor.h"

namespace haptic_emu {
namespace {

/** Items of HID 1.11, section 6.2.2. */
class Writer {
 public:
  void page(int p) { item(0x05, p); }
  void usage(int u) { item(0x09, u); }
  void id(int i) { item(0x85, i); }
  void range(int low, int high) {
    item(0x15, low);
    item(0x25, high);
  }
  void size(int bits, int count) {
    item(0x75, bits);
    item(0x95, count);
  }
  void unit(int what, int exponent) {
    item(0x65, what);
    item(0x55, exponent);
  }
  void begin(int usage_in_page, int type) {
    usage(usage_in_page);
    item(0xa1, type);
  }
  void end() { bytes.push_back(0xc0); }
  void input(int flags) { item(0x81, flags); }
  void output(int flags) { item(0x91, flags); }
  void feature(int flags) { item(0xb1, flags); }
  /** One number of an output report. */
  void number(int usage_in_page, int bits, int low, int high) {
    usage(usage_in_page);
    range(low, high);
    size(bits, 1);
    output(2);
  }
  /** One of several. */
  void choice(int collection, std::initializer_list<int> usages, bool feature_report) {
    begin(collection, 2);
    for (const int u : usages) usage(u);
    range(1, static_cast<int>(usages.size()));
    size(8, 1);
    feature_report ? feature(0) : output(0);
    end();
  }
  void padding(int bits) {
    size(bits, 1);
    output(3);
  }

  std::vector<std::uint8_t> bytes;

 private:
  void item(int prefix, int value) {
    const int bytes_needed = value >= -128 && value < 128 ? 1 : value >= -32768 && value < 32768 ? 2 : 4;
    bytes.push_back(static_cast<std::uint8_t>(prefix - 1 + (bytes_needed == 4 ? 3 : bytes_needed)));
    for (int i = 0; i < bytes_needed; ++i, value >>= 8) bytes.push_back(static_cast<std::uint8_t>(value & 0xff));
  }
};

void joystick(Writer& w, const PidVariant& v) {
  w.id(1);
  w.page(9);
  w.range(0, 1);
  w.size(1, 8);
  for (int b = 1; b <= 8; ++b) w.usage(b);
  w.input(2);
  if (v.buttons_apart) w.id(kAxesApart);
  w.page(1);
  w.range(-32767, 32767);
  w.size(16, v.axes);
  for (int a = 0; a < v.axes; ++a) w.usage(0x30 + a);
  w.input(2);
  w.page(0x0f);
  w.begin(0x92, 2);  // state
  w.id(2);
  w.range(0, 1);
  w.size(1, 5);
  for (const int u : {0x9f, 0xa0, 0xa4, 0xa5, 0xa6}) w.usage(u);
  w.input(2);
  w.size(3, 1);
  w.input(3);
  w.size(1, 1);
  w.usage(0x94);
  w.input(2);
  w.usage(0x22);
  w.range(0, 40);
  w.size(7, 1);
  w.input(2);
  w.end();
}

void setEffect(Writer& w, const PidVariant& v) {
  w.begin(0x21, 2);
  w.id(1);
  w.number(0x22, 8, 1, 40);
  w.choice(0x25, {0x26, 0x27, 0x30, 0x31, 0x32, 0x33, 0x34, 0x40, 0x41, 0x42, 0x43, 0x28}, false);
  w.unit(0x1003, v.time_exponent);  // Seconds.
  w.number(0x50, 16, 0, 0x7fff);
  w.unit(0, 0);
  w.number(0x54, 16, 0, 0x7fff);
  w.number(0x51, 16, 0, 0x7fff);
  if (v.start_delay) w.number(0xa7, 16, 0, 0x7fff);
  w.number(0x52, 8, 0, 255);
  w.number(0x53, 8, 1, 8);
  w.begin(0x55, 2);  // axes enable
  w.page(1);
  w.range(0, 1);
  w.size(1, v.axes);
  for (int a = 0; a < v.axes; ++a) w.usage(0x30 + a);
  w.output(2);
  w.page(0x0f);
  w.end();
  w.number(0x56, 1, 0, 1);
  w.padding(7 - v.axes);
  w.begin(0x57, 2);  // direction
  w.page(0x0a);
  w.range(0, 255);
  w.size(8, 2);
  w.usage(1);
  w.usage(2);
  w.output(2);
  w.page(0x0f);
  w.end();
  w.end();
}

void condition(Writer& w, const PidVariant& v) {
  w.begin(0x5f, 2);
  w.id(3);
  w.number(0x22, 8, 1, 40);
  if (v.block_offset) {
    w.number(0x23, 4, 0, 1);
    w.padding(4);
  }
  w.number(0x60, 16, -10000, 10000);
  w.number(0x61, 16, -10000, 10000);
  if (v.negative_coefficient) w.number(0x62, 16, -10000, 10000);
  if (v.saturation) w.number(0x63, 16, 0, 10000);
  if (v.saturation) w.number(0x64, 16, 0, 10000);
  if (v.dead_band) w.number(0x65, 16, 0, 10000);
  w.end();
}

void control(Writer& w, const PidVariant& v) {
  w.begin(0x96, 2);
  w.id(12);
  for (int u = v.switches ? 0x97 : 0x99; u <= 0x9c; ++u) w.usage(u);
  if (v.control_in_bits) {
    w.range(0, 1);
    w.size(1, 6);
    w.output(2);
    w.padding(2);
  } else {
    w.range(v.switches ? 1 : 3, 6);
    w.size(8, 1);
    w.output(0);
  }
  w.end();
}

void features(Writer& w) {
  w.begin(0xab, 2);  // create new effect
  w.id(5);
  w.choice(0x25, {0x26, 0x27, 0x30, 0x31, 0x32, 0x33, 0x34, 0x40, 0x41, 0x42, 0x43, 0x28}, true);
  w.page(1);
  w.usage(0x3b);
  w.range(0, 511);
  w.size(10, 1);
  w.feature(2);
  w.size(6, 1);
  w.feature(3);
  w.page(0x0f);
  w.end();
  w.begin(0x89, 2);  // block load
  w.id(6);
  w.usage(0x22);
  w.range(0, 40);
  w.size(8, 1);
  w.feature(2);
  w.choice(0x8b, {0x8c, 0x8d, 0x8e}, true);
  w.usage(0xac);
  w.range(0, 0x7fff);
  w.size(16, 1);
  w.feature(2);
  w.end();
}

}  // namespace

std::vector<std::uint8_t> pidDescriptor(const PidVariant& v) {
  Writer w;
  w.page(1);
  w.begin(4, 1);
  joystick(w, v);
  setEffect(w, v);
  if (v.conditions) condition(w, v);
  w.begin(0x73, 2);  // constant force
  w.id(5);
  w.number(0x22, 8, 1, 40);
  w.number(0x70, 16, -10000, 10000);
  w.end();
  w.begin(0x77, 2);  // effect operation
  w.id(10);
  w.number(0x22, 8, 1, 40);
  w.choice(0x78, {0x79, 0x7a, 0x7b}, false);
  w.number(0x7c, 8, 0, 255);
  w.end();
  w.begin(0x90, 2);  // block free
  w.id(11);
  w.number(0x22, 8, 1, 40);
  w.end();
  control(w, v);
  w.begin(0x7d, 2);  // device gain
  w.id(13);
  w.number(0x7e, 8, 0, 255);
  w.end();
  features(w);
  w.end();
  return w.bytes;
}

}  // namespace haptic_emu
