#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace styled::train {

class Means;

// Work of a CUDA device that is recorded once and launched as a whole from then on (a CUDA graph):
// a network of small layers costs the CPU more to launch, kernel by kernel, than the device to
// compute. The work must read and write tensors that stay where they are in memory, and must not
// wait for the device or read from the host. One thread.
class RecordedWork {
 public:
  RecordedWork();
  ~RecordedWork();
  RecordedWork(RecordedWork&&) noexcept;
  RecordedWork& operator=(RecordedWork&&) noexcept;

  // Runs `work`, which adds to `means`; from the fourth time on its record. The first runs allocate
  // what libraries keep. Throws libtorch's errors of a recording that failed.
  void Run(Means& means, const std::function<void()>& work);

 private:
  struct Record;
  std::unique_ptr<Record> record_;
  int runs_ = 0;
};

// From now on this thread's work is queued on a stream that can be recorded. Throws where libtorch
// has no CUDA.
void UseRecordableStream();

// Waits until the device has done all that was queued.
void WaitForDevice();

}  // namespace styled::train
