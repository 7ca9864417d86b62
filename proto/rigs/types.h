#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

// The list of rigs, one row each: what daemon, simulator and clients need to know about a rig
// besides its format. Nothing here depends on the daemon.
//
// A new rig is a row in STYLED_RIGS, and three functions named after it, in files of its own:
//   daemon/source/rigs/  source::Make<Name>(const config::Source&): its translator
//   sim/rigs/            rigs::Make<Name>(const Options&): its stand-in
//   clients/doctor/  a case of Sniffer::Sniff for Format::k<Name>: what the doctor knows it by
namespace styled::rigs {

struct RigType {
  std::string_view word;  // for programs: stylesim --as, the doctor's --json
  std::string_view name;  // for people
  // source.type in styled.toml, by transport; "" if the rig does not use that transport.
  std::string_view datagrams = "", stream = "", usb = "";
  // Where a source listens when the configuration gives no address, numeric; "" = the address is
  // required.
  std::string_view listen = "";
  // The rig sends only a face, for the performer of another source.
  bool face_only = false;
  // Whether its face, or its fingers, can be merged into the performer of another source
  // (source.parts).
  bool has_face = false, has_fingers = false;
  // Whether source.server applies (the address to which data requests go), and source.expressions
  // (the names that its expressions get).
  bool takes_server = false, takes_expressions = false;
  // The rig is a server that answers requests, instead of a sender that connects to us; and its
  // usual port. With `stream` the transport connects to it.
  bool asks_server = false;
  std::uint16_t server_port = 0;
  // Usual ports at the receiver, for the doctor; 0: none.
  std::array<std::uint16_t, 2> ports{};
  // The name of its skeleton in model/rig/dialects.h; "" = the sender states it.
  std::string_view dialect = "";
  // For the doctor: what to check in the sender, one or two sentences.
  std::string_view in_the_sender = "";
};

// clang-format off
#define STYLED_RIGS(RIG)                                                                      \
  RIG(IFacialMocap, .word = "ifacialmocap", .name = "iFacialMocap",                           \
      .datagrams = "ifacialmocap", .listen = "0.0.0.0:49983", .face_only = true,              \
      .has_face = true, .takes_server = true, .takes_expressions = true, .ports = {49983},    \
      .in_the_sender =                                                                        \
          "The phone sends on request: set `server` of the source to the phone's "     \
          "address, and open the app.")                                                       \
  RIG(LiveLinkFace, .word = "livelinkface", .name = "Live Link Face",                         \
      .datagrams = "livelinkface", .listen = "0.0.0.0:11111", .face_only = true,              \
      .has_face = true, .takes_expressions = true, .ports = {11111},                                                     \
      .in_the_sender =                                                                        \
          "In the app: Settings, Live Link: add a target with this machine's address and "    \
          "port, capture mode Live Link (ARKit).")                                            \
  RIG(Mocopi, .word = "mocopi", .name = "Sony mocopi", .datagrams = "mocopi",                 \
      .listen = "0.0.0.0:12351", .ports = {12351}, .dialect = "mocopi",                       \
      .in_the_sender =                                                                        \
          "In the mocopi app: Settings, PC connection: address and port, format mocopi "      \
          "(UDP); then press Send.")                                                          \
  RIG(Mvn, .word = "mvn", .name = "Xsens MVN", .datagrams = "mvn", .stream = "mvn-tcp",       \
      .listen = "0.0.0.0:9763", .has_fingers = true, .ports = {9763},                         \
      .in_the_sender =                                                                        \
          "In MVN: Options, Network Streamer: add a target with address and port, protocol "  \
          "UDP, and tick Position + Orientation (Quaternion).")                               \
  RIG(NatNet, .word = "natnet", .name = "OptiTrack NatNet", .datagrams = "natnet",            \
      .listen = "0.0.0.0:0", .has_fingers = true, .takes_server = true, .asks_server = true,  \
      .server_port = 1510, .ports = {1511},                                                   \
      .dialect = "motive",                                                                    \
      .in_the_sender =                                                                        \
          "In Motive: Streaming: Broadcast Frame Data on, Skeletons on, Local Interface not " \
          "loopback.")                                                                        \
  RIG(Qtm, .word = "qtm", .name = "Qualisys QTM", .stream = "qtm", .listen = "0.0.0.0:0",       \
      .has_fingers = true, .takes_server = true, .asks_server = true, .server_port = 22223,   \
      .in_the_sender =                                                                        \
          "In QTM: the skeletons of the project switched on and solved in real time, a "      \
          "measurement running (or Play with real-time output), and in Project Options, "     \
          "Real-Time Output, the base port 22222.")                                           \
  RIG(Rokoko, .word = "rokoko", .name = "Rokoko Studio", .datagrams = "rokoko",               \
      .listen = "0.0.0.0:14043", .has_face = true, .has_fingers = true,                       \
      .takes_expressions = true, .ports = {14043},                                            \
      .dialect = "rokoko",                                                                    \
      .in_the_sender =                                                                        \
          "In Rokoko Studio: Livestream, Custom: forward IP and port, data format JSON v3.")  \
  RIG(SlimeVr, .word = "slimevr", .name = "SlimeVR", .datagrams = "slimevr",                  \
      .usb = "slimevr-usb", .listen = "0.0.0.0:6969", .ports = {6969},                        \
      .dialect = "canonical",                                                                 \
      .in_the_sender =                                                                        \
          "Trackers look for their server by broadcast: they must be in this machine's "      \
          "network, and no SlimeVR server may run here.")                                     \
  RIG(Vmc, .word = "vmc", .name = "VMC", .datagrams = "vmc", .listen = "0.0.0.0:39540",       \
      .has_face = true, .has_fingers = true,                                                  \
      .ports = {39540, 39539}, .dialect = "vmc",                                              \
      .in_the_sender =                                                                        \
          "In the sending app switch the VMC (OSC) sender on and set address and port.")          \
  RIG(VrChat, .word = "vrchat", .name = "VRChat OSC trackers", .datagrams = "vrchat",         \
      .listen = "0.0.0.0:9000", .ports = {9000, 9001}, .dialect = "canonical",                \
      .in_the_sender =                                                                        \
          "In the sending app switch OSC trackers for VRChat on and set address and port 9000.")
// clang-format on

// Our own protocol (proto/styled/v1/WIRE.md), which needs no translator.
inline constexpr RigType kNative{
    .word = "native",
    .name = "styled's own format",
    .datagrams = "udp",
    .stream = "tcp",
    .usb = "usb",
    .has_face = true,
    .has_fingers = true,
    .ports = {7000},
    .in_the_sender = "Look at the sender's address and port (stylesim: --to udp://HOST:PORT)."};

// kMocopi, kMvn, ... by themselves, and all of them in the order of the rows.
#define STYLED_RIG(Name, ...) inline constexpr RigType k##Name{__VA_ARGS__};
STYLED_RIGS(STYLED_RIG)
#undef STYLED_RIG
#define STYLED_RIG(Name, ...) k##Name,
inline constexpr std::array kRigs = std::to_array<RigType>({STYLED_RIGS(STYLED_RIG)});
#undef STYLED_RIG

// One value of source.type: a rig and a transport.
struct SourceType {
  std::string_view name;
  bool stream = false;             // TCP
  std::string_view usual_address;  // default if nothing is configured; "" = must be configured
  bool usb = false;                // no address at all
  const RigType* rig = &kNative;

  // We connect to the rig's server; else we listen.
  constexpr bool connects() const noexcept { return stream && rig->asks_server; }
};

namespace detail {
constexpr std::size_t CountTypes() {
  std::size_t count = 3;  // of kNative
  for (const RigType& rig : kRigs) {
    for (const auto name : {rig.datagrams, rig.stream, rig.usb}) count += name.empty() ? 0 : 1;
  }
  return count;
}
constexpr auto MakeTypes() {
  std::array<SourceType, CountTypes()> types{};
  std::size_t count = 0;
  const auto add = [&](const RigType& rig) {
    if (!rig.datagrams.empty()) types[count++] = {rig.datagrams, false, rig.listen, false, &rig};
    if (!rig.stream.empty()) types[count++] = {rig.stream, true, rig.listen, false, &rig};
    if (!rig.usb.empty()) types[count++] = {rig.usb, false, "", true, &rig};
  };
  add(kNative);
  for (const RigType& rig : kRigs) add(rig);
  return types;
}
}  // namespace detail

inline constexpr auto kSourceTypes = detail::MakeTypes();

namespace detail {
inline std::string TypesWith(bool RigType::*what) {
  std::string types;
  for (const SourceType& type : kSourceTypes) {
    if (type.rig->*what) types.append(types.empty() ? "" : ", ").append(type.name);
  }
  return types;
}
}  // namespace detail

// The types whose face, or whose fingers, may be merged into a performer, "udp, tcp, usb, ...".
inline std::string FaceTypes() { return detail::TypesWith(&RigType::has_face); }
inline std::string FingerTypes() { return detail::TypesWith(&RigType::has_fingers); }
// The types to which source.server and source.expressions apply.
inline std::string ServerTypes() { return detail::TypesWith(&RigType::takes_server); }
inline std::string ExpressionTypes() { return detail::TypesWith(&RigType::takes_expressions); }

// The type of that name, or null.
constexpr const SourceType* FindSourceType(std::string_view name) noexcept {
  for (const SourceType& type : kSourceTypes) {
    if (type.name == name) return &type;
  }
  return nullptr;
}

}  // namespace styled::rigs
