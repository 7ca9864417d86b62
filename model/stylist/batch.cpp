#include "model/stylist/batch.h"

#include <array>

namespace styled::stylist {

template <std::size_t kMost>
void StepTogether(std::span<const BatchEntry> entries) noexcept {
  std::array<Predictor::Step, kMost> steps;
  std::array<const BatchEntry*, kMost> stepping;
  std::array<net::StepJob, kMost> jobs;
  // One round steps every performer's next state that is due. Most frames are one tick, so one
  // round.
  for (;;) {
    std::size_t count = 0;
    for (const BatchEntry& entry : entries) {
      Predictor::Step& step = steps[count];
      if (!entry.predictor->Next(*entry.input, step)) continue;
      jobs[count] = entry.predictor->JobOf(step, *entry.mixer);
      if (entry.performer.neutral != nullptr) jobs[count].performer = &entry.performer;
      stepping[count++] = &entry;
    }
    if (count == 0) return;
    // One call per run of performers with the same network: all of them, except while a reload is
    // being adopted.
    for (std::size_t from = 0, to = 0; from < count; from = to) {
      const net::Stylizer* const network = stepping[from]->predictor->network();
      while (to < count && stepping[to]->predictor->network() == network) ++to;
      network->Step(std::span(jobs).subspan(from, to - from));
    }
    for (std::size_t i = 0; i < count; ++i) {
      const BatchEntry& entry = *stepping[i];
      entry.predictor->Accept(steps[i], *entry.mixer, *entry.near);
    }
  }
}

template void StepTogether<1>(std::span<const BatchEntry>) noexcept;
template void StepTogether<net::kTogether>(std::span<const BatchEntry>) noexcept;

}  // namespace styled::stylist
