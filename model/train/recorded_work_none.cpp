// Where libtorch has no CUDA: there is no device whose work could be recorded.
#include <torch/torch.h>

#include "model/train/recorded_work.h"

namespace styled::train {

struct RecordedWork::Record {};

RecordedWork::RecordedWork() = default;
RecordedWork::~RecordedWork() = default;
RecordedWork::RecordedWork(RecordedWork&&) noexcept = default;
RecordedWork& RecordedWork::operator=(RecordedWork&&) noexcept = default;

void RecordedWork::Run(Means& /*means*/, const std::function<void()>& /*work*/) {
  TORCH_CHECK(false, "this libtorch has no CUDA");
}
void UseRecordableStream() { TORCH_CHECK(false, "this libtorch has no CUDA"); }
void WaitForDevice() {}

}  // namespace styled::train
