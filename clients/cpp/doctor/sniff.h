#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "clients/cpp/doctor/format.h"
#include "proto/rigs/natnet/packet.h"

namespace styled::doctor {

// What a datagram is worth to the daemon.
enum class Verdict : std::uint8_t {
  kPose,      // a pose, or its part
  kSkeleton,  // what poses belong to
  kTalk,      // of the format, and says nothing of a pose: names, time, greetings
  kUseless,   // of the format, but in a version or mode that the daemon cannot use
  kDamaged,   // begins as the format does, and is cut, changed or not well-formed
  kCut,       // only its beginning was seen, which is the format's
  kForeign    // no format that the daemon takes
};
const char* Name(Verdict verdict);

struct Sniffed {
  Format format = Format::kUnknown;
  Verdict verdict = Verdict::kForeign;
  // In words of the format, few different ones: "quaternions (02)", "OSC, but no VMC: /foo".
  std::string kind;
};

// Names the format of datagrams, by the codecs of proto/rigs. Of NatNet it keeps the version that a
// server named. Allocates; bytes may be anything. One thread.
// Pinned by tests/unit/doctor/sniff_test.cpp.
class Sniffer {
 public:
  Sniffer();
  ~Sniffer();
  Sniffer(const Sniffer&) = delete;
  Sniffer& operator=(const Sniffer&) = delete;

  Sniffed Sniff(std::span<const std::byte> datagram);
  // Of a datagram of which only the beginning is there.
  Sniffed SniffStart(std::span<const std::byte> start);

  void set_natnet_version(natnet::Version version) { natnet_version_ = version; }

 private:
  struct Scratch;
  std::optional<Sniffed> SniffNatNet(std::span<const std::byte> bytes);
  std::optional<Sniffed> SniffRokoko(std::span<const std::byte> bytes);

  std::unique_ptr<Scratch> scratch_;
  std::optional<natnet::Version> natnet_version_;
};

// How long the record at the front of a TCP stream is: by the header of the formats that stream;
// 0: not all of it is there; of anything else: all of `received`.
std::size_t RecordSize(std::span<const std::byte> received);

}  // namespace styled::doctor
