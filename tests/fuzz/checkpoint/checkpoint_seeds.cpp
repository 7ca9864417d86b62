// Writes checkpoints of a performer as seeds of checkpoint_fuzz: at the first frame, in the middle
// of a change of style, and later.
#include <span>
#include <string>

#include "tests/fuzz/checkpoint/stage.h"
#include "tests/fuzz/write_seeds.h"

namespace {

using namespace styled;

std::vector<std::byte> CheckpointAfter(int frames) {
  support::FakePipeline pipeline(fuzz::CheckpointConfig(), "");
  support::Rig rig("a");
  pipeline.Deliver({rig.Body()});
  v1::Request style;
  style.set_performer("rig.a");
  auto& mix = *style.mutable_set()->add_mix();
  mix.set_style("style1");
  mix.set_weight(1);
  for (int i = 0; i < frames; ++i) {
    if (i == 5) (void)pipeline.Ask(style);
    pipeline.clock.now_ns += 8'333'333;
    pipeline.Deliver({rig.Frame()});
  }
  v1::Request request;
  request.set_performer("rig.a");
  request.mutable_take_checkpoint();
  const std::string bytes = pipeline.Ask(request).checkpoint().SerializeAsString();
  const auto span = std::as_bytes(std::span(bytes));
  return {span.begin(), span.end()};
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::WriteSeeds(argc, argv,
                          {CheckpointAfter(1), CheckpointAfter(9), CheckpointAfter(60)});
}
