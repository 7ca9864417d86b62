// Fuzzes the journal messages between a leader and its standby. A client that may write there
// is trusted with what is shown (CURVE keys), not with the daemon's life: for any bytes,
// - published values are finite, and rotations have unit length;
// - three seconds later one of the two leads, and the other follows;
// - when the leader is killed, the other daemon leads within 2 s, and publishes the rig's frames.
// The first byte: 1, the message gets version, sender, epoch, term, number, hearing and hold of the
// leader's next one, so that it is not refused for them; 2, it comes to the leader; 3, both, with
// the standby's.
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
  const bool to_leader = (data[0] & 2U) != 0;
  fuzz::Pair pair;
  const auto listen = [&last](const std::string& message) { last.ParseFromString(message); };
  (to_leader ? pair.wire.spy_on_b : pair.wire.spy) = listen;
  pair.Frames(4);
  auto& inbox = to_leader ? pair.wire.to_a : pair.wire.to_b;
  if ((data[0] & 1U) != 0 && data[0] < 4 && is_message) {
    entry.set_version(last.version());
    entry.set_daemon(last.daemon());
    entry.set_epoch(last.epoch());
    entry.set_term(last.term());
    entry.set_role(last.role());
    entry.set_number(last.number() + 1);
    entry.set_hears(last.hears());
    entry.set_hold_ns(last.hold_ns());
    inbox.push_back(entry.SerializeAsString());
  } else {
    inbox.emplace_back(reinterpret_cast<const char*>(data + 1), size - 1);
  }
  pair.Turn(1);
  pair.Frames(5);
  pair.Turn(3000);
  const std::string one = pair.leader().State().role(), other = pair.standby().State().role();
  if ((one == "leading") == (other == "leading")) {
    std::fprintf(stderr, "%s, %s\n", one.c_str(), other.c_str());
  }
  REQUIRE((one == "leading") != (other == "leading"));
  REQUIRE(one == "following" || other == "following");
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
