#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>

// Management messages of IEEE 1588-2008 (clause 15), as ptp4l answers them on its UNIX socket: the
// GET requests of four data sets, and their replies. All numbers are big-endian. Allocates only
// where a string is returned. Pinned by tests/unit/ptp (replies of a real ptp4l) and
// tests/witness/ptp.
namespace styled::ptp {

using ClockIdentity = std::array<std::uint8_t, 8>;

// "001122.fffe.334455", as linuxptp writes it.
std::string Text(const ClockIdentity& identity);

enum class DataSet : std::uint16_t {
  kCurrent = 0x2001,
  kParent = 0x2002,
  kTimeProperties = 0x2003,
  kPort = 0x2004,
};

struct Current {
  std::uint16_t steps_removed = 0;  // from the leader; 0: this clock is the leader
  double offset_s = 0, mean_path_delay_s = 0;
};
struct Parent {
  ClockIdentity leader{};  // the grandmaster
  std::uint8_t priority1 = 0, priority2 = 0;
  std::uint8_t clock_class = 0, accuracy = 0;  // codes of clauses 7.6.2.4 and 7.6.2.5
};
struct TimeProperties {
  std::uint8_t time_source = 0;  // code of clause 7.6.2.6
};
enum class PortState : std::uint8_t {
  kNone,
  kInitializing,
  kFaulty,
  kDisabled,
  kListening,
  kPreMaster,
  kMaster,
  kPassive,
  kUncalibrated,
  kSlave,
};
// "SLAVE"; "NONE" for a value that is not a state.
std::string Text(PortState state);
struct Port {
  std::uint16_t number = 0;
  PortState state = PortState::kNone;
};

inline constexpr std::size_t kRequestBytes = 54;
// Asks all ports of a clock of that domain.
std::array<std::byte, kRequestBytes> Get(DataSet data, std::uint8_t domain, std::uint16_t sequence);

struct Reply {
  std::uint8_t domain = 0;
  std::variant<Current, Parent, TimeProperties, Port> data;
};
// Empty if the message is not a reply to such a request: another message, an error, or a truncated
// one.
std::optional<Reply> Read(std::span<const std::byte> message);

}  // namespace styled::ptp
