#include "daemon/source/usb/descriptors.h"

#include <gtest/gtest.h>

#include <vector>

namespace styled::source::usb {
namespace {

constexpr std::uint8_t kInterrupt = 3, kBulk = 2, kIsochronous = 1;

libusb_endpoint_descriptor Endpoint(std::uint8_t address, std::uint8_t type, std::uint16_t size) {
  libusb_endpoint_descriptor endpoint{};
  endpoint.bEndpointAddress = address;
  endpoint.bmAttributes = type;
  endpoint.wMaxPacketSize = size;
  return endpoint;
}

// A configuration as libusb gives it, one alternate setting after another.
class Config {
 public:
  struct Class {
    std::uint8_t klass = 0, subclass = 0, protocol = 0;
  };

  Config& Add(int number, Class what, std::vector<libusb_endpoint_descriptor> endpoints,
              int alternate = 0) {
    endpoints_.push_back(std::move(endpoints));
    libusb_interface_descriptor setting{};
    setting.bInterfaceNumber = static_cast<std::uint8_t>(number);
    setting.bAlternateSetting = static_cast<std::uint8_t>(alternate);
    setting.bInterfaceClass = what.klass;
    setting.bInterfaceSubClass = what.subclass;
    setting.bInterfaceProtocol = what.protocol;
    settings_.push_back(setting);
    return *this;
  }

  std::optional<Interface> Find(Protocol protocol) {
    std::vector<libusb_interface> interfaces;
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      settings_[i].bNumEndpoints = static_cast<std::uint8_t>(endpoints_[i].size());
      settings_[i].endpoint = endpoints_[i].data();
      const bool same = i > 0 && settings_[i].bInterfaceNumber == settings_[i - 1].bInterfaceNumber;
      if (same) {
        ++interfaces.back().num_altsetting;
      } else {
        interfaces.push_back({&settings_[i], 1});
      }
    }
    libusb_config_descriptor config{};
    config.bNumInterfaces = static_cast<std::uint8_t>(interfaces.size());
    config.interface = interfaces.data();
    return FindInterface(protocol, config);
  }

 private:
  std::vector<std::vector<libusb_endpoint_descriptor>> endpoints_;
  std::vector<libusb_interface_descriptor> settings_;
};

constexpr Config::Class kHid{3, 0, 0}, kSerial{10, 0, 0}, kOurs{0xFF, 'S', 1};

TEST(DescriptorsTest, AnInterfaceOfAnotherClassIsNotTaken) {
  EXPECT_FALSE(Config().Find(Protocol::kSlimeVr));
  EXPECT_FALSE(Config().Find(Protocol::kNative));
  EXPECT_FALSE(Config().Add(0, kSerial, {Endpoint(0x81, kInterrupt, 64)}).Find(Protocol::kSlimeVr));
  for (const Config::Class& other :
       {Config::Class{0xFF, 'S', 2}, {0xFF, 'T', 1}, {0xFE, 'S', 1}, {0xFF, 0, 0}, kHid}) {
    EXPECT_FALSE(Config().Add(0, other, {Endpoint(0x81, kBulk, 512)}).Find(Protocol::kNative));
  }
}

TEST(DescriptorsTest, AnEndpointOfAnotherDirectionTypeOrSizeIsNotTaken) {
  for (const auto& other :
       {Endpoint(0x01, kInterrupt, 64), Endpoint(0x81, kBulk, 64), Endpoint(0x81, kIsochronous, 64),
        Endpoint(0x81, kInterrupt, 63), Endpoint(0x81, kInterrupt, 8)}) {
    EXPECT_FALSE(Config().Add(0, kHid, {other}).Find(Protocol::kSlimeVr));
  }
  for (const auto& other : {Endpoint(0x01, kBulk, 512), Endpoint(0x81, kInterrupt, 512)}) {
    EXPECT_FALSE(Config().Add(0, kOurs, {other}).Find(Protocol::kNative));
  }
  EXPECT_FALSE(Config().Add(0, kHid, {}).Find(Protocol::kSlimeVr));
}

TEST(DescriptorsTest, AnAlternateSettingOtherThan0IsNotTaken) {
  EXPECT_FALSE(Config()
                   .Add(0, kHid, {})
                   .Add(0, kHid, {Endpoint(0x81, kInterrupt, 64)}, 1)
                   .Find(Protocol::kSlimeVr));
}

TEST(DescriptorsTest, TheInterfaceIsFoundByItsClassWhateverItsNumber) {
  Config receiver;
  receiver.Add(0, {2, 2, 0}, {Endpoint(0x82, kInterrupt, 64)})
      .Add(1, kSerial, {Endpoint(0x01, kBulk, 64), Endpoint(0x83, kBulk, 64)})
      .Add(5, kHid, {Endpoint(0x02, kInterrupt, 64), Endpoint(0x84, kInterrupt, 64)});
  const auto found = receiver.Find(Protocol::kSlimeVr);
  EXPECT_EQ(found, (Interface{5, 0x84, false}));
  EXPECT_FALSE(receiver.Find(Protocol::kNative));

  Config suit;
  suit.Add(0, {0xFF, 0, 0}, {Endpoint(0x81, kBulk, 512)})
      .Add(1, kOurs, {Endpoint(0x02, kBulk, 512), Endpoint(0x83, kBulk, 1024)});
  EXPECT_EQ(suit.Find(Protocol::kNative), (Interface{1, 0x83, true}));
}

TEST(DescriptorsTest, AKeyboardBesideTheReportsIsPassedOver) {
  Config composite;
  composite.Add(0, {3, 1, 1}, {Endpoint(0x81, kInterrupt, 8)})
      .Add(1, kHid, {Endpoint(0x82, kInterrupt, 64)});
  EXPECT_EQ(composite.Find(Protocol::kSlimeVr), (Interface{1, 0x82, false}));
}

TEST(DescriptorsTest, WithoutAnIdAllKnownReceiversAreWantedAndNothingElse) {
  const auto wanted = [](std::uint16_t vendor, std::uint16_t product) {
    return IsWanted(Protocol::kSlimeVr, {}, {vendor, product});
  };
  EXPECT_TRUE(wanted(0x1209, 0x7690));
  EXPECT_TRUE(wanted(0x1209, 0x7692));
  EXPECT_TRUE(wanted(0x4E76, 0xD2D0));
  EXPECT_TRUE(wanted(0x4E76, 0xD2DF));
  EXPECT_FALSE(wanted(0x1209, 0x7691));
  EXPECT_FALSE(wanted(0x4E76, 0xD2E0));
  EXPECT_FALSE(wanted(0x1234, 0x7690));
  EXPECT_FALSE(IsWanted(Protocol::kNative, {}, {0x1209, 0x7690}));
}

TEST(DescriptorsTest, WithAnIdThatOneAloneIsWanted) {
  const config::UsbId id{0x1234, 0xABCD};
  for (const Protocol protocol : {Protocol::kSlimeVr, Protocol::kNative}) {
    EXPECT_TRUE(IsWanted(protocol, id, id));
    EXPECT_FALSE(IsWanted(protocol, id, {0x1209, 0x7690}));
  }
}

}  // namespace
}  // namespace styled::source::usb
