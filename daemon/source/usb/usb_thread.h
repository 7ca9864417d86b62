#pragma once

#include <libusb-1.0/libusb.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/config/address.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/usb/descriptors.h"
#include "daemon/source/usb/device.h"
#include "daemon/source/usb/reports.h"
#include "model/base/status.h"

namespace styled::source::usb {

// Which devices to open: all that IsWanted() accepts, or the one of them with this serial number.
struct Wanted {
  Protocol protocol = Protocol::kSlimeVr;
  std::optional<config::UsbId> id;
  std::string serial;  // "" = any
};

// Runs libusb's context and event loop on a thread of its own, because opening a device and reading
// its strings block. Opens every wanted device when it appears and puts its data into `reports`,
// which must outlive this object. Devices are found by libusb's hotplug events and by a scan once a
// second (for systems without hotplug, and to retry devices that could not be opened). Logs which
// devices were opened and lost, and why one could not be opened.
class UsbThread {
 public:
  // Errors: no USB on this system.
  static Result<std::unique_ptr<UsbThread>> Start(Wanted wanted, Reports& reports,
                                                  runtime::Clock& clock,
                                                  runtime::Counters& counters);
  // Stops the thread and closes the devices.
  ~UsbThread();
  UsbThread(const UsbThread&) = delete;
  UsbThread& operator=(const UsbThread&) = delete;

 private:
  struct Unref {
    void operator()(libusb_device* device) const { libusb_unref_device(device); }
  };
  struct Exit {
    void operator()(libusb_context* context) const { libusb_exit(context); }
  };
  // A wanted device on the bus.
  struct Known {
    std::unique_ptr<libusb_device, Unref> device;
    std::string name;  // for the log
    std::unique_ptr<Device> open;
    bool other = false;     // not wanted: other serial number, or no suitable interface
    std::string complaint;  // the last logged reason why it is not open
    int failures = 0;       // how often it was opened and given up
    std::int64_t next_try_ns = 0;
  };

  UsbThread(Wanted wanted, Reports& reports, runtime::Clock& clock, runtime::Counters& counters);
  void Run();
  void Scan();
  void Meet(libusb_device* device);
  void TryOpen(Known& known);
  Status Open(Known& known);
  void ServiceAll();
  void CloseAll();
  bool HandleEvents(std::int64_t until_ns);

  Wanted wanted_;
  Reports& reports_;
  runtime::Clock& clock_;
  runtime::Counters& counters_;
  std::unique_ptr<libusb_context, Exit> context_;
  std::vector<Known> known_;  // declared after context_: destroyed before it
  std::uint32_t openings_ = 0;
  bool scan_now_ = false;  // a device was plugged in or out
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace styled::source::usb
