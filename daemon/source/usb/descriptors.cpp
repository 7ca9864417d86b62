#include "daemon/source/usb/descriptors.h"

#include <span>

namespace styled::source::usb {
namespace {

constexpr std::uint8_t kSubclassStyled = 'S';
constexpr std::uint8_t kProtocolRecords = 1;
constexpr unsigned kHidReportBytes = 64;

bool Speaks(Protocol protocol, const libusb_interface_descriptor& setting) noexcept {
  if (protocol == Protocol::kSlimeVr) return setting.bInterfaceClass == LIBUSB_CLASS_HID;
  return setting.bInterfaceClass == LIBUSB_CLASS_VENDOR_SPEC &&
         setting.bInterfaceSubClass == kSubclassStyled &&
         setting.bInterfaceProtocol == kProtocolRecords;
}

bool Carries(Protocol protocol, const libusb_endpoint_descriptor& endpoint) noexcept {
  if ((endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) == 0) return false;
  const unsigned type = endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK;
  if (protocol == Protocol::kNative) return type == LIBUSB_ENDPOINT_TRANSFER_TYPE_BULK;
  constexpr unsigned kSizeBits = 0x7FF;  // above them: transactions per microframe
  return type == LIBUSB_ENDPOINT_TRANSFER_TYPE_INTERRUPT &&
         (endpoint.wMaxPacketSize & kSizeBits) == kHidReportBytes;
}

}  // namespace

bool IsWanted(Protocol protocol, const std::optional<config::UsbId>& id,
              const config::UsbId& device) noexcept {
  if (id) return device == *id;
  if (protocol != Protocol::kSlimeVr) return false;
  return device == config::UsbId{0x1209, 0x7690} || device == config::UsbId{0x1209, 0x7692} ||
         (device.vendor == 0x4E76 && (device.product & 0xFFF0U) == 0xD2D0);
}

std::optional<Interface> FindInterface(Protocol protocol,
                                       const libusb_config_descriptor& config) noexcept {
  for (const auto& interface : std::span(config.interface, config.bNumInterfaces)) {
    for (const auto& setting :
         std::span(interface.altsetting, static_cast<std::size_t>(interface.num_altsetting))) {
      if (setting.bAlternateSetting != 0 || !Speaks(protocol, setting)) continue;
      for (const auto& endpoint : std::span(setting.endpoint, setting.bNumEndpoints)) {
        if (!Carries(protocol, endpoint)) continue;
        return Interface{setting.bInterfaceNumber, endpoint.bEndpointAddress,
                         protocol == Protocol::kNative};
      }
    }
  }
  return std::nullopt;
}

}  // namespace styled::source::usb
