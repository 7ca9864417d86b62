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

// Which devices are opened: all that IsWanted(), or the one of them with this serial number.
struct Wanted {
  Protocol protocol = Protocol::kSlimeVr;
  std::optional<config::UsbId> id;
  std::string serial;  // "" = any
};

// libusb's context and its event loop on a thread of their own, because opening a device and
// reading its strings block. Opens what is wanted when it appears (libusb's hotplug events, and a
// look around once a second: for systems without them, and for what could not be opened before),
// as many as there are, and puts what they send into `reports`, which must outlive it. Says in the
// log what it opened, lost, and why it could not.
class UsbThread {
 public:
  // Errors: no USB on this system.
  static Result<std::unique_ptr<UsbThread>> Start(Wanted wanted, Reports& reports,
                                                  runtime::Clock& clock,
                                                  runtime::Counters& counters);
  // Stops the thread and gives the devices back.
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
  // A device that is on the bus and wanted.
  struct Known {
    std::unique_ptr<libusb_device, Unref> device;
    std::string name;  // for the log
    std::unique_ptr<Device> open;
    bool other = false;     // has another serial number, or no such interface
    std::string complaint;  // said why it is not open
    int failures = 0;       // so often it was opened and given up
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
  std::vector<Known> known_;  // behind the context: gone before it
  std::uint32_t openings_ = 0;
  bool scan_now_ = false;  // a device came or went
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace styled::source::usb
