#include "proto/ptp/management.h"

#include <cstdio>

namespace styled::ptp {
namespace {

// Offsets within a message: header, then the management fields, then one TLV.
constexpr std::size_t kLength = 2, kDomain = 4, kSource = 20, kSequence = 30, kControl = 32,
                      kInterval = 33, kTarget = 34, kAction = 46, kTlv = 48, kTlvLength = 50,
                      kId = 52, kData = 54;
constexpr std::uint8_t kManagement = 0x0d, kVersion2 = 2, kControlManagement = 4,
                       kNoInterval = 0x7f;
constexpr std::uint8_t kResponse = 2;
constexpr std::uint16_t kManagementTlv = 1;
constexpr double kScaledNs = 1e-9 / 65536;  // s per unit of a TimeInterval

std::uint8_t Byte(std::span<const std::byte> m, std::size_t at) {
  return std::to_integer<std::uint8_t>(m[at]);
}
std::uint64_t Number(std::span<const std::byte> m, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8U | Byte(m, at + i);
  return value;
}
double Interval_s(std::span<const std::byte> m, std::size_t at) {
  return static_cast<double>(static_cast<std::int64_t>(Number(m, at, 8))) * kScaledNs;
}

}  // namespace

std::string Text(const ClockIdentity& id) {
  std::array<char, 24> text{};
  (void)std::snprintf(text.data(), text.size(), "%02x%02x%02x.%02x%02x.%02x%02x%02x", id[0], id[1],
                      id[2], id[3], id[4], id[5], id[6], id[7]);
  return text.data();
}

std::string Text(PortState state) {
  constexpr std::array kNames{"NONE",       "INITIALIZING", "FAULTY",  "DISABLED",     "LISTENING",
                              "PRE_MASTER", "MASTER",       "PASSIVE", "UNCALIBRATED", "SLAVE"};
  return kNames[static_cast<std::size_t>(state)];
}

std::array<std::byte, kRequestBytes> Get(DataSet data, std::uint8_t domain,
                                         std::uint16_t sequence) {
  std::array<std::byte, kRequestBytes> m{};
  const auto put = [&m](std::size_t at, std::uint16_t value) {
    m[at] = static_cast<std::byte>(value >> 8U);
    m[at + 1] = static_cast<std::byte>(value & 0xffU);
  };
  m[0] = std::byte{kManagement};
  m[1] = std::byte{kVersion2};
  put(kLength, kRequestBytes);
  m[kDomain] = std::byte{domain};
  put(kSource + 8, 1);  // this program is port 1 of a clock without an identity
  put(kSequence, sequence);
  m[kControl] = std::byte{kControlManagement};
  m[kInterval] = std::byte{kNoInterval};
  for (std::size_t i = kTarget; i < kTarget + 10; ++i) m[i] = std::byte{0xff};  // all ports
  put(kTlv, kManagementTlv);
  put(kTlvLength, 2);  // the id alone
  put(kId, static_cast<std::uint16_t>(data));
  return m;
}

std::optional<Reply> Read(std::span<const std::byte> m) {
  if (m.size() < kData || (Byte(m, 0) & 0xfU) != kManagement || (Byte(m, 1) & 0xfU) != kVersion2) {
    return std::nullopt;
  }
  const std::size_t data_bytes = m.size() - kData;
  if ((Byte(m, kAction) & 0xfU) != kResponse || Number(m, kTlv, 2) != kManagementTlv ||
      Number(m, kTlvLength, 2) != data_bytes + 2) {
    return std::nullopt;
  }
  Reply reply{Byte(m, kDomain), {}};
  switch (static_cast<DataSet>(Number(m, kId, 2))) {
    case DataSet::kCurrent: {
      if (data_bytes < 18) return std::nullopt;
      reply.data = Current{static_cast<std::uint16_t>(Number(m, kData, 2)),
                           Interval_s(m, kData + 2), Interval_s(m, kData + 10)};
      return reply;
    }
    case DataSet::kParent: {
      if (data_bytes < 32) return std::nullopt;
      Parent parent;
      parent.priority1 = Byte(m, kData + 18);
      parent.clock_class = Byte(m, kData + 19);
      parent.accuracy = Byte(m, kData + 20);
      parent.priority2 = Byte(m, kData + 23);
      for (std::size_t i = 0; i < parent.leader.size(); ++i) {
        parent.leader[i] = Byte(m, kData + 24 + i);
      }
      reply.data = parent;
      return reply;
    }
    case DataSet::kTimeProperties: {
      if (data_bytes < 4) return std::nullopt;
      reply.data = TimeProperties{Byte(m, kData + 3)};
      return reply;
    }
    case DataSet::kPort: {
      if (data_bytes < 11) return std::nullopt;
      const std::uint8_t state = Byte(m, kData + 10);
      reply.data =
          Port{static_cast<std::uint16_t>(Number(m, kData + 8, 2)),
               state <= static_cast<std::uint8_t>(PortState::kSlave) ? static_cast<PortState>(state)
                                                                     : PortState::kNone};
      return reply;
    }
  }
  return std::nullopt;
}

}  // namespace styled::ptp
