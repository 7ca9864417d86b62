#include "daemon/config/config.h"

#include <gtest/gtest.h>

#include "daemon/config/address.h"
#include "tests/support/child.h"

namespace styled::config {
namespace {

std::string Refusal(const std::string& source) {
  const support::TemporaryFolder folder;
  const std::string file = folder / "styled.toml";
  support::WriteText(file, "[[source]]\n" + source);
  return Load(file, {}).status().message();
}

TEST(UsbConfigTest, AnInvalidUsbIdIsRefused) {
  for (const char* text : {"", "1209", "1209:769", "1209-7690", "1209:76901", "12g9:7690",
                           "1209:769x", "+209:7690", "-209:7690", " 209:7690", "0x12:7690"}) {
    EXPECT_FALSE(ParseUsbId(text).ok()) << text;
  }
  EXPECT_NE(ParseUsbId("x").status().message().find("expected VENDOR:PRODUCT"), std::string::npos);
}

TEST(UsbConfigTest, AUsbIdIsReadInEitherCase) {
  const auto id = ParseUsbId("4E76:d2D0");
  ASSERT_TRUE(id.ok());
  EXPECT_EQ(id.value(), (UsbId{0x4E76, 0xD2D0}));
  EXPECT_EQ(ToText(id.value()), "4e76:d2d0");
}

TEST(UsbConfigTest, AnAddressOrABadOrMissingIdOfAUsbSourceIsRefused) {
  EXPECT_NE(Refusal("type = \"slimevr-usb\"\nlisten = \"127.0.0.1:7000\"").find("source.0.listen"),
            std::string::npos);
  EXPECT_NE(Refusal("type = \"usb\"").find("source.0.usb_id: missing"), std::string::npos);
  EXPECT_NE(Refusal("type = \"usb\"\nusb_id = \"suit\"").find("source.0.usb_id: \"suit\""),
            std::string::npos);
}

TEST(UsbConfigTest, AUsbSourceNeedsNoAddress) {
  const support::TemporaryFolder folder;
  const std::string file = folder / "styled.toml";
  support::WriteText(file,
                     "[[source]]\ntype = \"slimevr-usb\"\n"
                     "[[source]]\ntype = \"slimevr-usb\"\nserial = \"A1\"\n"
                     "[[source]]\ntype = \"usb\"\nusb_id = \"1234:ABCD\"\n");
  const auto config = Load(file, {});
  ASSERT_TRUE(config.ok()) << config.status().message();
  EXPECT_EQ(config.value().sources[0].listen, "");
  EXPECT_EQ(config.value().sources[1].serial, "A1");
  EXPECT_EQ(config.value().sources[2].usb_id, "1234:ABCD");
}

}  // namespace
}  // namespace styled::config
