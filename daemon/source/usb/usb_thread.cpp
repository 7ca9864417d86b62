#include "daemon/source/usb/usb_thread.h"

#include <pthread.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <span>

namespace styled::source::usb {
namespace {

using runtime::Counter;

constexpr std::int64_t kScanEvery_ns = runtime::kSecond_ns;
// The pause before a failed device is retried doubles at most this many times, from 1 s.
constexpr int kMostDoublings = 6;
constexpr std::int64_t kClosing_ns = runtime::kSecond_ns;
constexpr auto kPauseOnError = std::chrono::milliseconds(10);

std::string NameOf(libusb_device* device, const config::UsbId& id) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "USB device %s (bus %u, device %u)",
                config::ToText(id).c_str(), libusb_get_bus_number(device),
                libusb_get_device_address(device));
  return text.data();
}

std::string Why(int error) {
  if (error == LIBUSB_ERROR_ACCESS) return "permission denied: are the udev rules installed?";
  return libusb_strerror(error);
}

std::optional<Interface> InterfaceOf(libusb_device* device, Protocol protocol) {
  libusb_config_descriptor* config = nullptr;
  if (libusb_get_active_config_descriptor(device, &config) != LIBUSB_SUCCESS) return {};
  const auto found = FindInterface(protocol, *config);
  libusb_free_config_descriptor(config);
  return found;
}

// The serial number, "" if there is none. Blocks.
std::string SerialOf(libusb_device* device, libusb_device_handle* handle) {
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS) return "";
  if (descriptor.iSerialNumber == 0) return "";
  std::array<unsigned char, 256> text{};
  const int size = libusb_get_string_descriptor_ascii(handle, descriptor.iSerialNumber, text.data(),
                                                      static_cast<int>(text.size()));
  return size <= 0 ? "" : std::string(text.begin(), text.begin() + size);
}

int LIBUSB_CALL OnHotplug(libusb_context*, libusb_device*, libusb_hotplug_event, void* scan_now) {
  *static_cast<bool*>(scan_now) = true;
  return 0;
}

}  // namespace

UsbThread::UsbThread(Wanted wanted, Reports& reports, runtime::Clock& clock,
                     runtime::Counters& counters)
    : wanted_(std::move(wanted)), reports_(reports), clock_(clock), counters_(counters) {}

Result<std::unique_ptr<UsbThread>> UsbThread::Start(Wanted wanted, Reports& reports,
                                                    runtime::Clock& clock,
                                                    runtime::Counters& counters) {
  std::unique_ptr<UsbThread> usb(new UsbThread(std::move(wanted), reports, clock, counters));
  libusb_context* context = nullptr;
  const int result = libusb_init(&context);
  if (result != LIBUSB_SUCCESS) {
    return Status::Error(std::string("USB cannot be used here: ") + libusb_strerror(result));
  }
  usb->context_.reset(context);
  if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) != 0) {
    // If the registration fails, the scan once a second remains.
    (void)libusb_hotplug_register_callback(
        context, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT,
        LIBUSB_HOTPLUG_NO_FLAGS, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY,
        LIBUSB_HOTPLUG_MATCH_ANY, OnHotplug, &usb->scan_now_, nullptr);
  }
  usb->thread_ = std::thread([thread = usb.get()] { thread->Run(); });
  return usb;
}

UsbThread::~UsbThread() {
  if (!thread_.joinable()) return;
  stop_ = true;
  libusb_interrupt_event_handler(context_.get());
  thread_.join();
}

void UsbThread::Run() {
  pthread_setname_np(pthread_self(), "usb");
  std::int64_t next_scan_ns = 0;
  while (!stop_) {
    if (scan_now_ || clock_.Now_ns() >= next_scan_ns) {
      scan_now_ = false;
      Scan();
      next_scan_ns = clock_.Now_ns() + kScanEvery_ns;
      if (stop_) break;  // reading a string may have consumed the interruption
    }
    if (!HandleEvents(next_scan_ns)) std::this_thread::sleep_for(kPauseOnError);
    ServiceAll();
  }
  CloseAll();
}

bool UsbThread::HandleEvents(std::int64_t until_ns) {
  const std::int64_t wait_ns = std::max<std::int64_t>(until_ns - clock_.Now_ns(), 0);
  timeval wait{wait_ns / runtime::kSecond_ns, wait_ns % runtime::kSecond_ns / 1000};
  const int result = libusb_handle_events_timeout_completed(context_.get(), &wait, nullptr);
  return result == LIBUSB_SUCCESS || result == LIBUSB_ERROR_INTERRUPTED;
}

void UsbThread::Scan() {
  libusb_device** list = nullptr;
  const auto count = libusb_get_device_list(context_.get(), &list);
  if (count < 0) return;
  const std::span present(list, static_cast<std::size_t>(count));
  for (Known& known : known_) {
    const bool gone = std::ranges::find(present, known.device.get()) == present.end();
    if (gone && known.open != nullptr) known.open->Stop("unplugged");
  }
  std::erase_if(known_, [&present](const Known& known) {
    return known.open == nullptr && std::ranges::find(present, known.device.get()) == present.end();
  });
  for (libusb_device* device : present) Meet(device);
  libusb_free_device_list(list, 1);
  for (Known& known : known_) TryOpen(known);
}

// Adds a new device to known_ if a source needs it.
void UsbThread::Meet(libusb_device* device) {
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS) return;
  const config::UsbId id{descriptor.idVendor, descriptor.idProduct};
  if (!IsWanted(wanted_.protocol, wanted_.id, id)) return;
  for (const Known& known : known_) {
    if (known.device.get() == device) return;
  }
  Known met;
  met.device.reset(libusb_ref_device(device));
  met.name = NameOf(device, id);
  known_.push_back(std::move(met));
}

void UsbThread::TryOpen(Known& known) {
  if (known.open != nullptr || known.other || clock_.Now_ns() < known.next_try_ns) return;
  const Status status = Open(known);
  if (status.ok() || known.complaint == status.message()) return;
  known.complaint = status.message();
  reports_.PushNote(known.name + ": " + known.complaint);
}

Status UsbThread::Open(Known& known) {
  const auto interface = InterfaceOf(known.device.get(), wanted_.protocol);
  if (!interface) {
    known.other = true;
    return Status::Error(wanted_.protocol == Protocol::kNative
                             ? "has no interface of class FF, subclass 53, protocol 1 with a bulk "
                               "IN endpoint"
                             : "has no HID interface with an interrupt IN endpoint of 64 bytes");
  }
  libusb_device_handle* opened = nullptr;
  const int result = libusb_open(known.device.get(), &opened);
  if (result != LIBUSB_SUCCESS) return Status::Error("cannot be opened: " + Why(result));
  Device::OwnedHandle handle(opened);
  const std::string serial = SerialOf(known.device.get(), opened);
  if (!wanted_.serial.empty() && serial != wanted_.serial) {
    known.other = true;
    return Status::Error("left alone: its serial number is \"" + serial + "\"");
  }
  auto device = Device::Start(std::move(handle), *interface, openings_ + 1, reports_, counters_);
  if (!device.ok()) return device.status();
  ++openings_;
  known.open = std::move(device.value());
  known.complaint.clear();
  counters_.Add(Counter::kUsbOpened);
  reports_.PushNote(known.name + ": opened, serial number \"" + serial + "\"");
  return Status::Ok();
}

void UsbThread::ServiceAll() {
  for (Known& known : known_) {
    if (known.open == nullptr) continue;
    known.open->Service();
    if (!known.open->done()) continue;
    counters_.Add(Counter::kUsbLostDevices);
    reports_.PushNote(known.name + ": lost, " + known.open->reason());
    known.open.reset();
    const int doublings = std::min(known.failures++, kMostDoublings);
    known.next_try_ns = clock_.Now_ns() + (runtime::kSecond_ns << doublings);
  }
}

void UsbThread::CloseAll() {
  for (Known& known : known_) {
    if (known.open != nullptr) known.open->Stop("stopped");
  }
  const auto under_way = [](const Known& known) {
    return known.open != nullptr && !known.open->done();
  };
  const std::int64_t end_ns = clock_.Now_ns() + kClosing_ns;
  while (std::ranges::any_of(known_, under_way) && clock_.Now_ns() < end_ns) {
    if (!HandleEvents(end_ns)) break;
  }
}

}  // namespace styled::source::usb
