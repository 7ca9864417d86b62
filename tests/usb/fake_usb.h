#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace styled::support {

// A machine's USB as this process and its children see it, made by umockdev: /sys, /dev/bus/usb and
// udev's events, all in a temporary folder. One at a time.
class FakeUsb {
 public:
  // Restarts this program with umockdev's library preloaded, where it is installed and is not
  // yet; returns otherwise. The first thing in main().
  static void Preload(char** argv);
  // Whether that worked.
  static bool Available();

  FakeUsb();
  ~FakeUsb();
  FakeUsb(const FakeUsb&) = delete;
  FakeUsb& operator=(const FakeUsb&) = delete;

 private:
  friend class FakeDevice;
  struct Testbed;
  std::unique_ptr<Testbed> testbed_;
};

// A device on it, or taken away from it. Answers usbfs' ioctls as the kernel does: transfers are
// finished in their order as data comes, a stalled endpoint stays so until it is cleared, a device
// that goes finishes all its transfers with ESHUTDOWN. Any thread.
class FakeDevice {
 public:
  enum class Kind {
    kReceiver,  // SlimeVR's: CDC-ACM on interfaces 0 and 1, HID on 2
    kVendor     // our own records, USB.md
  };
  FakeDevice(FakeUsb& usb, Kind kind, std::uint16_t vendor, std::uint16_t product,
             std::string serial);
  ~FakeDevice();  // unplugged
  FakeDevice(const FakeDevice&) = delete;
  FakeDevice& operator=(const FakeDevice&) = delete;

  // Each time with the bus' next device number. A program that opens it finds it at once.
  void Plug();
  void Unplug();

  // The data that the device sends, as one transfer; waits in it until there is one under way.
  void Send(std::span<const std::byte> bytes);
  // Behind what was sent so far: the endpoint stalls.
  void Stall();
  // Behind what was sent so far: `count` transfers fail with this error (EPROTO, EOVERFLOW).
  void Fail(int count, int error);
  // So many claims are refused with EBUSY.
  void RefuseClaims(int count);

  struct Counts {
    int claims = 0, refused_claims = 0;
    int driver_detached = 0, driver_attached = 0;  // the kernel's
    int halts_cleared = 0;
    int under_way = 0;  // transfers, now
    int waiting = 0;    // sends, stalls and failures that found no transfer, now
    bool claimed = false;
  };
  Counts counts() const;
  // Waits until so many transfers are under way and nothing is waiting; false after `seconds`.
  bool WaitForTransfers(int under_way, double seconds = 10) const;

 private:
  struct Usbfs;
  std::unique_ptr<Usbfs> usbfs_;
};

}  // namespace styled::support
