// Fuzzes the doctor's parsers: untrusted datagrams, captured packets and streams, and the output of
// other programs: firewall rulesets and socket tables.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "clients/doctor/capture.h"
#include "clients/doctor/firewall.h"
#include "clients/doctor/sniff.h"
#include "clients/doctor/sockets.h"

namespace doctor = styled::doctor;

namespace {

constexpr std::size_t kMaxKind = 80;

void Require(bool condition) {
  if (!condition) std::abort();
}

// The text for the report must be short and contain no control characters.
void Check(const doctor::Sniffed& what) {
  Require((what.format == doctor::Format::kUnknown) == (what.verdict == doctor::Verdict::kForeign));
  Require(!what.kind.empty() && what.kind.size() <= kMaxKind);
  Require(
      std::all_of(what.kind.begin(), what.kind.end(), [](char c) { return c >= ' ' && c <= '~'; }));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  static doctor::Sniffer sniffer;
  Check(sniffer.Sniff(bytes));
  Check(sniffer.SniffStart(bytes));
  Require(doctor::RecordSize(bytes) <= size);
  if (const auto packet = doctor::ParsePacket(bytes)) {
    Require(packet->payload.data() >= bytes.data() &&
            packet->payload.data() + packet->payload.size() <= bytes.data() + size);
    Require(doctor::IsNumeric(packet->from.host) && doctor::IsNumeric(packet->to.host));
    Check(sniffer.Sniff(packet->payload));
  }
  const std::string text(reinterpret_cast<const char*>(data), size);
  const doctor::Firewall firewall = doctor::Firewall::FromJson(text);
  for (const std::uint16_t port : {2, 4, 5}) {
    const auto judgement = firewall.Judge({false, port, "", ""});
    Require(judgement.rule.empty() == (judgement.verdict == doctor::Firewall::Verdict::kPasses));
  }
  (void)doctor::ParseSocketTable(text, false);
  return 0;
}
