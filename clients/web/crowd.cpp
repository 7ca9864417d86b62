#include "clients/web/crowd.h"

#include <algorithm>
#include <utility>

namespace styled::web {

Crowd::Member::Member(std::shared_ptr<Crowd> crowd, std::function<void()> close)
    : crowd_(std::move(crowd)), close_(std::move(close)) {
  place_ = crowd_->members_.insert(crowd_->members_.end(), this);
}

Crowd::Member::~Member() {
  if (counted_) crowd_->members_.erase(place_);
}

void Crowd::Member::Now(State state) {
  state_ = state;
  auto& members = crowd_->members_;
  if (counted_) members.splice(members.end(), members, place_);
}

bool Crowd::MakeRoom() {
  for (const State state : {State::kReading, State::kWriting}) {
    const auto found =
        std::find_if(members_.begin(), members_.end(),
                     [state](const Member* member) { return member->state_ == state; });
    if (found == members_.end()) continue;
    Member& member = **found;
    members_.erase(found);
    member.counted_ = false;
    member.close_();
    return true;
  }
  return false;
}

}  // namespace styled::web
