#pragma once

#include <libusb-1.0/libusb.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/runtime/counters.h"
#include "daemon/source/usb/descriptors.h"
#include "daemon/source/usb/reports.h"
#include "model/base/status.h"

namespace styled::source::usb {

// One open device. Its interface is claimed (the kernel's driver is detached until it is closed),
// and 8 interrupt transfers of 64 bytes or 4 bulk transfers of 16 KiB are always submitted, so that
// the device never has to wait for the host. USB thread alone; opening blocks. The libusb context
// must outlive it.
class Device {
 public:
  struct Handle {
    void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
  };
  using OwnedHandle = std::unique_ptr<libusb_device_handle, Handle>;

  // Claims the interface and starts the transfers. `number` is attached to all data that the device
  // reports. Errors name the refused call.
  static Result<std::unique_ptr<Device>> Start(OwnedHandle handle, const Interface& interface,
                                               std::uint32_t number, Reports& reports,
                                               runtime::Counters& counters);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  // Call after every round of libusb's events, for work that is not allowed inside them: once all
  // transfers of a stalled endpoint have returned, clears the stall and submits them again.
  void Service();
  // Cancels the transfers. `reason` must be a string literal.
  void Stop(const char* reason);
  // Whether the device is stopped, unplugged or given up (16 failures without a success in between)
  // and no transfer is pending: it may be destroyed.
  bool done() const { return state_ == State::kEnding && under_way_ == 0; }
  // The reason: "unplugged", "its transfers fail", or that of the first Stop().
  const char* reason() const { return reason_; }

 private:
  enum class State : std::uint8_t { kStreaming, kStalled, kEnding };
  struct FreeTransfer {
    void operator()(libusb_transfer* transfer) const { libusb_free_transfer(transfer); }
  };
  using Transfer = std::unique_ptr<libusb_transfer, FreeTransfer>;

  Device(OwnedHandle handle, const Interface& interface, std::uint32_t number, Reports& reports,
         runtime::Counters& counters);
  Status Claim();
  static void OnTransfer(libusb_transfer* transfer);
  void Complete(libusb_transfer& transfer);
  void Fail(State next);
  bool Submit(libusb_transfer& transfer);
  void SubmitAll();
  void CancelAll();

  // handle_ is declared after transfers_, so that the device is closed before its transfers are
  // freed; closing detaches them from libusb, whatever their state.
  std::vector<std::byte> buffer_;
  std::vector<Transfer> transfers_;
  OwnedHandle handle_;
  Interface interface_;
  std::uint32_t number_;
  Reports& reports_;
  runtime::Counters& counters_;
  State state_ = State::kStreaming;
  const char* reason_ = "";
  int under_way_ = 0;
  int failures_ = 0;  // since the last success
};

}  // namespace styled::source::usb
