#pragma once

#include <libusb-1.0/libusb.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/runtime/counters.h"
#include "daemon/source/usb/descriptors.h"
#include "daemon/source/usb/reports.h"
#include "model/base/status.h"

namespace styled::source::usb {

// One open device: its interface claimed (the kernel's driver steps aside until it is closed), 8
// interrupt transfers of 64 bytes or 4 bulk transfers of 16 KiB always under way, so that none of
// its data waits for us. USB thread alone; opening blocks. The libusb context outlives it.
class Device {
 public:
  struct Handle {
    void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
  };
  using OwnedHandle = std::unique_ptr<libusb_device_handle, Handle>;

  // Claims and starts. `number` goes with all that it reports. Errors say what was refused.
  static Result<std::unique_ptr<Device>> Start(OwnedHandle handle, const Interface& interface,
                                               std::uint32_t number, Reports& reports,
                                               runtime::Counters& counters);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  // To be called after every round of libusb's events: what must not be done inside them. A stalled
  // endpoint is drained, cleared and started again.
  void Service();
  // Cancels what is under way. `reason`: a literal.
  void Stop(const char* reason);
  // Stopped, unplugged or given up (16 failures with no success between), and nothing under way:
  // ready to be destroyed.
  bool done() const { return state_ == State::kEnding && under_way_ == 0; }
  // Why: "unplugged", "its transfers fail", or what Stop() was told first.
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
  void Take(libusb_transfer& transfer);
  void Fail(State next);
  bool Submit(libusb_transfer& transfer);
  void SubmitAll();
  void CancelAll();

  // Closed before they are freed: that takes them away from libusb, whatever became of them.
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
