#include "model/train/recorded_work.h"

#include <ATen/cuda/CUDAGraph.h>
#include <c10/cuda/CUDAStream.h>
#include <torch/torch.h>

#include "model/train/means.h"

namespace styled::train {
namespace {

constexpr int kRunsBefore = 3;  // as many as the libraries need until they allocate no more

}  // namespace

struct RecordedWork::Record {
  at::cuda::CUDAGraph graph;
  std::vector<std::string> names;  // of the means that it adds to
};

RecordedWork::RecordedWork() = default;
RecordedWork::~RecordedWork() = default;
RecordedWork::RecordedWork(RecordedWork&&) noexcept = default;
RecordedWork& RecordedWork::operator=(RecordedWork&&) noexcept = default;

void RecordedWork::Run(Means& means, const std::function<void()>& work) {
  if (runs_ < kRunsBefore) {
    work();
    ++runs_;
    return;
  }
  if (record_ == nullptr) {
    WaitForDevice();
    record_ = std::make_unique<Record>();
    // Relaxed: another thread may allocate pinned memory meanwhile.
    record_->graph.capture_begin({0, 0}, cudaStreamCaptureModeRelaxed);
    record_->names = means.NamesOf(work);  // is recorded, and does not run
    record_->graph.capture_end();
  }
  record_->graph.replay();
  means.Count(record_->names);
}

void UseRecordableStream() {
  WaitForDevice();  // the new stream waits for no other
  c10::cuda::setCurrentCUDAStream(c10::cuda::getStreamFromPool(false));
}

void WaitForDevice() { torch::cuda::synchronize(); }

}  // namespace styled::train
