// Fuzzes what a standby hears of its leader. Whoever may write there is trusted with what is shown
// (CURVE keys), not with the daemon's life: whatever comes,
// - published values are finite, and rotations have unit length;
// - when the leader is killed, the standby leads within 2 s, and publishes the rig's frames.
// The first byte: 1, the message gets version, sender, epoch, term and number of the leader's next
// one, so that it is not refused for them.
#include <google/protobuf/stubs/logging.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "proto/styled/v1/journal.pb.h"
#include "tests/fuzz/journal/pair.h"
#include "tests/fuzz/sane_frame.h"

namespace {

using namespace styled;

using fuzz::Require;

void RequireSane(const std::vector<v1::Frame>& frames) {
  for (const v1::Frame& frame : frames) fuzz::RequireSane(frame);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  [[maybe_unused]] static auto* const quiet = google::protobuf::SetLogHandler(nullptr);
  if (size < 1) return 0;
  v1::Journal entry, last;
  const bool is_message = entry.ParseFromArray(data + 1, static_cast<int>(size - 1));
  fuzz::Pair pair;
  pair.wire.spy = [&last](const std::string& message) { last.ParseFromString(message); };
  pair.Frames(2);
  if (data[0] == 1 && is_message) {
    entry.set_version(last.version());
    entry.set_daemon(last.daemon());
    entry.set_epoch(last.epoch());
    entry.set_term(last.term());
    entry.set_role(last.role());
    entry.set_number(last.number() + 1);
    pair.wire.to_b.push_back(entry.SerializeAsString());
  } else {
    pair.wire.to_b.emplace_back(reinterpret_cast<const char*>(data + 1), size - 1);
  }
  pair.Turn(1);
  pair.Frames(5);
  pair.Kill();
  pair.standby().publisher.frames.clear();
  pair.Frames(250);  // 2 s
  RequireSane(pair.standby().publisher.frames);
  const auto leads = pair.standby().State();
  if (leads.role() != "leading")
    std::fprintf(stderr, "%s: %s\n", leads.role().c_str(), leads.why_not().c_str());
  REQUIRE(leads.role() == "leading");
  pair.standby().publisher.frames.clear();
  pair.Frames(10);
  REQUIRE(pair.standby().publisher.frames.size() >= 10);
  RequireSane(pair.standby().publisher.frames);
  return 0;
}
