#include "proto/rigs/vmc/device.h"

#include <algorithm>
#include <array>

namespace styled::vmc {
namespace {

constexpr std::array<std::string_view, 3> kAddresses{"/VMC/Ext/Hmd/Pos", "/VMC/Ext/Con/Pos",
                                                     "/VMC/Ext/Tra/Pos"};

}  // namespace

DecodeResult Decode(const osc::Message& bytes, Device& device) noexcept {
  const auto address = std::ranges::find(kAddresses, bytes.address);
  if (address == kAddresses.end()) return DecodeResult::kUnknownAddress;
  osc::Arguments arguments(bytes);
  const auto failed = [&arguments] {
    return arguments.AtEnd() ? DecodeResult::kTooFewArguments : DecodeResult::kWrongType;
  };
  Device read;
  read.kind = static_cast<Device::Kind>(address - kAddresses.begin());
  if (!arguments.Text(read.serial)) return failed();
  for (float& value : read.transform.position) {
    if (!arguments.Float(value)) return failed();
  }
  for (float& value : read.transform.rotation) {
    if (!arguments.Float(value)) return failed();
  }
  device = read;
  return DecodeResult::kOk;
}

void Put(const Device& device, osc::Writer& writer) noexcept {
  writer.BeginMessage(kAddresses[static_cast<std::size_t>(device.kind)], "sfffffff");
  writer.Text(device.serial);
  for (const float value : device.transform.position) writer.Float(value);
  for (const float value : device.transform.rotation) writer.Float(value);
  writer.EndMessage();
}

}  // namespace styled::vmc
