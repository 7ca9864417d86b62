#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "clients/doctor/format.h"
#include "proto/rigs/natnet/packet.h"

namespace styled::doctor {

// How the daemon would use a datagram.
enum class Verdict : std::uint8_t {
  kPose,      // a pose, or a part of one
  kSkeleton,  // a skeleton to which poses refer
  kTalk,      // the format's other messages: names, time, greetings
  kUseless,   // the right format, but a version or mode that the daemon cannot use
  kDamaged,   // starts like the format, but is truncated, altered or malformed
  kCut,       // only its start was captured, and that start has the format
  kForeign    // no format that the daemon accepts
};
const char* Name(Verdict verdict);

struct Sniffed {
  Format format = Format::kUnknown;
  Verdict verdict = Verdict::kForeign;
  // In the terms of the format, from a small set: "quaternions (02)", "OSC, but not VMC: /foo".
  std::string kind;
};

// Identifies the format of datagrams with the codecs of proto/rigs. Stateful only for NatNet: it
// keeps the version that a server announced. The bytes may be anything. Allocates. One thread.
// Pinned by tests/unit/doctor/sniff_test.cpp.
class Sniffer {
 public:
  Sniffer();
  ~Sniffer();
  Sniffer(const Sniffer&) = delete;
  Sniffer& operator=(const Sniffer&) = delete;

  Sniffed Sniff(std::span<const std::byte> datagram);
  // For a datagram of which only the start was captured.
  Sniffed SniffStart(std::span<const std::byte> start);

  void set_natnet_version(natnet::Version version) { natnet_version_ = version; }

 private:
  struct Scratch;
  std::optional<Sniffed> SniffNatNet(std::span<const std::byte> bytes);
  std::optional<Sniffed> SniffRokoko(std::span<const std::byte> bytes);

  std::unique_ptr<Scratch> scratch_;
  std::optional<natnet::Version> natnet_version_;
};

// Length of the record at the start of a TCP stream, from the header of those formats that use TCP.
// 0: the record is incomplete. Any other format: the size of `received`.
std::size_t RecordSize(std::span<const std::byte> received);

}  // namespace styled::doctor
