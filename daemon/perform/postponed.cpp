#include "daemon/perform/postponed.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace styled::pipeline {

bool Postponed::Has(int source, std::string_view performer) const noexcept {
  return std::ranges::any_of(frames_, [&](const auto& waiting) {
    return waiting->source == source && waiting->frame.performer == performer;
  });
}

bool Postponed::Add(int source, const source::SourceFrame& frame) {
  if (frames_.size() >= kMost) return false;
  frames_.push_back(std::make_unique<Frame>());
  frames_.back()->source = source;
  frames_.back()->frame = frames_.back()->memory.Keep(frame);
  return true;
}

std::deque<std::unique_ptr<Postponed::Frame>> Postponed::Pop() {
  return std::exchange(frames_, {});
}

void Postponed::PutBack(std::deque<std::unique_ptr<Frame>> rest) {
  std::ranges::move(frames_, std::back_inserter(rest));
  frames_ = std::move(rest);
}

}  // namespace styled::pipeline
