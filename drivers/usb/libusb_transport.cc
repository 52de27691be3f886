#include "drivers/usb/libusb_transport.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <libusb-1.0/libusb.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "drivers/usb/usbfs.h"
#include "rt/base/clock.h"

namespace hapticd {
namespace {

constexpr unsigned kControlTimeout_ms = 1000;
constexpr std::uint32_t kSendNow_ms = 20;
constexpr std::size_t kMostPacket = 512;  // High speed bulk.

UsbStatus fromTransfer(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return UsbStatus::kOk;
    case LIBUSB_TRANSFER_TIMED_OUT:
      return UsbStatus::kTimeout;
    case LIBUSB_TRANSFER_STALL:
      return UsbStatus::kStall;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return UsbStatus::kGone;
    case LIBUSB_TRANSFER_CANCELLED:
      return UsbStatus::kCancelled;
    default:
      return UsbStatus::kError;
  }
}

UsbStatus fromError(int error) {
  switch (error) {
    case LIBUSB_SUCCESS:
      return UsbStatus::kOk;
    case LIBUSB_ERROR_TIMEOUT:
      return UsbStatus::kTimeout;
    case LIBUSB_ERROR_PIPE:
      return UsbStatus::kStall;
    case LIBUSB_ERROR_NO_DEVICE:
      return UsbStatus::kGone;
    default:
      return UsbStatus::kError;
  }
}

int toErrno(int error) {
  switch (error) {
    case LIBUSB_ERROR_BUSY:
      return EBUSY;
    case LIBUSB_ERROR_ACCESS:
      return EACCES;
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return ENODEV;
    default:
      return EIO;
  }
}

class LibusbTransport final : public UsbTransport {
 public:
  LibusbTransport(const UsbInterface& interface, int fd) : interface_(interface), fd_(fd) {}

  ~LibusbTransport() override {
    cancelAll();
    for (Slot& slot : slots_) {
      if (!slot.underWay())
        libusb_free_transfer(slot.transfer);  // One that never ended is better lost than used again.
    }
    if (handle_ != nullptr) {
      if (claimed_) libusb_release_interface(handle_, interface_.number);  // The kernel's driver comes back by itself.
      libusb_close(handle_);
    }
    if (context_ != nullptr) libusb_exit(context_);
    close(fd_);
  }

  /** A libusb error, 0 for none. */
  int claim() {
    if (const int e = libusb_init(&context_); e != 0) return e;
    // Our own descriptor, so that sendNow() can go past libusb.
    if (const int e = libusb_wrap_sys_device(context_, fd_, &handle_); e != 0) return e;
    libusb_set_auto_detach_kernel_driver(handle_, 1);
    if (const int e = libusb_claim_interface(handle_, interface_.number); e != 0) return e;
    claimed_ = true;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      Slot& slot = slots_[i];
      slot.owner = this;
      slot.in = i < kMostPending;
      slot.transfer = libusb_alloc_transfer(0);
      if (slot.transfer == nullptr) return LIBUSB_ERROR_NO_MEM;
    }
    return 0;
  }

  UsbStatus control(const UsbControl& r) noexcept override {
    return fromError(std::min(0, libusb_control_transfer(handle_, r.request_type, r.request, r.value, r.index, nullptr,
                                                         0, kControlTimeout_ms)));
  }

  UsbStatus postIn() noexcept override { return post(true, {}); }
  UsbStatus postOut(std::span<const std::uint8_t> bytes) noexcept override { return post(false, bytes); }

  void poll(std::int64_t until_ns, UsbListener& listener) noexcept override {
    listener_ = &listener;
    ended_ = untold_count_ > 0 ? 1 : 0;
    tellAll();
    MonotonicClock clock;
    while (ended_ == 0) {
      const std::int64_t left_us = std::max<std::int64_t>(0, (until_ns - clock.now() + 999) / 1000);
      timeval wait{left_us / 1'000'000, left_us % 1'000'000};
      if (libusb_handle_events_timeout_completed(context_, &wait, &ended_) != 0 || clock.now() >= until_ns) break;
    }
    listener_ = nullptr;
  }

  void sendNow(std::span<const std::uint8_t> bytes) noexcept override {
    (void)usbfsSend(fd_, interface_.out, bytes, kSendNow_ms);
  }

 private:
  struct Slot {
    LibusbTransport* owner = nullptr;
    libusb_transfer* transfer = nullptr;
    bool in = false;
    bool pending = false;  ///< Posted, and its end not told.
    bool ended = false;    ///< Its end is to be told.
    std::array<std::uint8_t, kMostPacket> bytes{};
    [[nodiscard]] bool underWay() const { return pending && !ended; }
  };

  UsbStatus post(bool in, std::span<const std::uint8_t> bytes) noexcept {
    const auto slot =
        std::find_if(slots_.begin(), slots_.end(), [in](const Slot& s) { return s.in == in && !s.pending; });
    if (slot == slots_.end() || bytes.size() > kMostPacket) return UsbStatus::kError;
    std::copy(bytes.begin(), bytes.end(), slot->bytes.begin());
    const int length =
        static_cast<int>(in ? std::min<std::size_t>(interface_.packet_bytes, kMostPacket) : bytes.size());
    libusb_fill_bulk_transfer(slot->transfer, handle_, in ? interface_.in : interface_.out, slot->bytes.data(), length,
                              &LibusbTransport::done, &*slot, 0);
    if (interface_.interrupt) slot->transfer->type = LIBUSB_TRANSFER_TYPE_INTERRUPT;
    const int refused = libusb_submit_transfer(slot->transfer);
    slot->pending = refused == 0;
    return fromError(refused);
  }

  /** Called within poll(), and within control(), which waits with the same loop: then the next poll() tells it. */
  static void LIBUSB_CALL done(libusb_transfer* transfer) {
    auto& slot = *static_cast<Slot*>(transfer->user_data);
    LibusbTransport& self = *slot.owner;
    slot.ended = true;
    self.untold_[self.untold_count_++] = &slot;
    self.ended_ = 1;
    if (self.listener_ != nullptr) self.tellAll();
  }

  /** In the order in which they ended. */
  void tellAll() noexcept {
    for (std::size_t i = 0; i < untold_count_; ++i) {
      Slot& slot = *untold_[i];
      slot.pending = slot.ended = false;
      const UsbStatus status = fromTransfer(slot.transfer->status);
      if (slot.in) {
        const auto length = static_cast<std::size_t>(std::max(0, slot.transfer->actual_length));
        listener_->onIn(status, {slot.bytes.data(), status == UsbStatus::kOk ? length : 0});
      } else {
        listener_->onOut(status);
      }
    }
    untold_count_ = 0;
  }

  /** A transfer may only be freed when libusb has told its end; the kernel tells within milliseconds. */
  void cancelAll() noexcept {
    const auto pending = [this] {
      return std::any_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.underWay(); });
    };
    for (Slot& slot : slots_) {
      if (slot.underWay()) (void)libusb_cancel_transfer(slot.transfer);
    }
    for (int i = 0; i < 100 && pending(); ++i) {
      timeval wait{0, 10'000};
      (void)libusb_handle_events_timeout_completed(context_, &wait, nullptr);
    }
  }

  UsbInterface interface_;
  int fd_;
  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
  bool claimed_ = false;
  std::array<Slot, 2 * kMostPending> slots_;
  std::array<Slot*, 2 * kMostPending> untold_{};
  std::size_t untold_count_ = 0;
  UsbListener* listener_ = nullptr;
  int ended_ = 0;
};

}  // namespace

std::string_view describe(UsbStatus status) noexcept {
  switch (status) {
    case UsbStatus::kOk:
      return "done";
    case UsbStatus::kTimeout:
      return "no answer in time";
    case UsbStatus::kStall:
      return "refused by the device";
    case UsbStatus::kGone:
      return "the device is gone";
    case UsbStatus::kCancelled:
      return "cancelled";
    case UsbStatus::kError:
      break;
  }
  return "failed";
}

Result<std::unique_ptr<UsbTransport>> openLibusb(const UsbFound& device, const UsbInterface& interface) {
  static const bool once = libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY) == 0;  // We have the node.
  (void)once;
  const int fd = open(device.node().c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return usbOpenError(device, errno, {});
  auto transport = std::make_unique<LibusbTransport>(interface, fd);
  if (const int refused = transport->claim(); refused != 0) {
    return usbOpenError(device, toErrno(refused), usbInterfaceDriver(device, interface.number));
  }
  return std::unique_ptr<UsbTransport>(std::move(transport));
}

}  // namespace hapticd
