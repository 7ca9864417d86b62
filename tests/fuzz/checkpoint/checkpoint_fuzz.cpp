// Fuzzes RestoreCheckpoint: a checkpoint is refused with a reason, or the performer continues with
// sane frames. The checksum of the state is put right first, so that its content is fuzzed, too.
#include <google/protobuf/stubs/logging.h>

#include <cstdint>
#include <string>

#include "model/base/crc32c.h"
#include "tests/fuzz/checkpoint/stage.h"
#include "tests/fuzz/sane_frame.h"

namespace {

using namespace styled;
using fuzz::Require;

void Seal(v1::Checkpoint& checkpoint) {
  constexpr std::size_t kSum = 4;
  std::string state = checkpoint.state();
  if (state.size() < kSum) return;
  state.resize(state.size() - kSum);
  const std::uint32_t crc = Crc32c(std::as_bytes(std::span(state)));
  for (int bit = 0; bit < 32; bit += 8) state.push_back(static_cast<char>(crc >> bit & 0xffU));
  checkpoint.set_state(std::move(state));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static google::protobuf::LogSilencer silent;
  v1::Request request;
  request.set_performer("rig.a");
  auto& checkpoint = *request.mutable_restore_checkpoint()->mutable_checkpoint();
  if (!checkpoint.ParseFromArray(data, static_cast<int>(size))) return 0;
  Seal(checkpoint);
  support::FakePipeline pipeline(fuzz::CheckpointConfig(), "styled/rig.a/rig/");
  const v1::Reply reply = pipeline.Ask(request);
  if (reply.code() != v1::CODE_OK) {
    REQUIRE(!reply.reason().empty());
    REQUIRE(pipeline.StatsOf("rig.a").performer().empty());
    return 0;
  }
  support::Rig rig("a");
  pipeline.Deliver({rig.Body()});
  for (int i = 0; i < 4; ++i) {
    pipeline.clock.now_ns += 8'333'333;
    pipeline.Deliver({rig.Frame()});
  }
  for (const v1::Frame& frame : pipeline.publisher.frames) fuzz::RequireSane(frame);
  return 0;
}
