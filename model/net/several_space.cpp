#include "model/net/several_space.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace styled::net {
namespace {

bool FollowsGaits(const Stylizer& stylizer) {
  const auto& reference = stylizer.model().reference;
  return reference && reference->gaits;
}

StyleCode Joined(StyleCode gait, const StyleCode& other) {
  gait.insert(gait.end(), other.begin(), other.end());
  return gait;
}

}  // namespace

SeveralSpace::SeveralSpace(std::vector<Member> members, std::vector<Place> places,
                           std::vector<std::vector<int>> same)
    : members_(std::move(members)), places_(std::move(places)), same_(std::move(same)) {
  assert(!members_.empty());
  for (const Member& member : members_) {
    const Member*& first = FollowsGaits(*member.stylizer) ? gaits_ : others_;
    if (first == nullptr) first = &member;
  }
  if (gaits_ == nullptr) return;
  gait_size_ = gaits_->stylizer->space()->MakeCode({.sources = {{.style = 0}}}).size();
}

const SeveralSpace::Member& SeveralSpace::MemberOf(std::size_t network) const {
  return *std::find_if(members_.begin(), members_.end(),
                       [network](const Member& member) { return member.network == network; });
}

const SeveralSpace::Member* SeveralSpace::Named(const std::string& name) const {
  const auto found = std::find_if(members_.begin(), members_.end(), [&name](const Member& member) {
    return member.name == name || member.stylizer->model().family == name;
  });
  return found == members_.end() ? nullptr : &*found;
}

int SeveralSpace::least_frames() const noexcept {
  int least = members_.front().stylizer->space()->least_frames();
  for (const Member& member : members_) {
    least = std::min(least, member.stylizer->space()->least_frames());
  }
  return least;
}

std::vector<SeveralSpace::Part> SeveralSpace::Split(const StyleCode& code) const {
  for (const Member& member : members_) {
    if (member.stylizer->space()->IsCode(code)) return {{member.network, code}};
  }
  if (gaits_ == nullptr || others_ == nullptr || code.size() <= gait_size_) return {};
  const auto middle = code.begin() + static_cast<std::ptrdiff_t>(gait_size_);
  const StyleCode gait(code.begin(), middle), other(middle, code.end());
  if (!gaits_->stylizer->space()->IsCode(gait) || !others_->stylizer->space()->IsCode(other)) {
    return {};
  }
  return {{gaits_->network, gait}, {others_->network, other}};
}

// Styles by their numbers in the member's network.
StyleCode SeveralSpace::MadeBy(const Member& member, const StyleRequest& request) const {
  StyleRequest theirs = request;
  for (StyleSource& source : theirs.sources) {
    if (source.style >= 0) {
      source.style = same_[static_cast<std::size_t>(source.style)][member.network];
    }
  }
  return member.stylizer->space()->MakeCode(theirs);
}

// An example with a gait is a pair, or a style of the network of gaits if there is no other. One
// without belongs to the other network; only an example that does not move does not.
StyleCode SeveralSpace::MadeByExample(const StyleRequest& request) const {
  if (gaits_ == nullptr) return MadeBy(*others_, request);
  StyleCode gait = MadeBy(*gaits_, request);
  const bool enough = std::ranges::all_of(request.sources, [this](const StyleSource& source) {
    return static_cast<int>(source.reference.size()) >=
           (others_ == nullptr ? 0 : others_->stylizer->space()->least_frames());
  });
  if (others_ == nullptr || !enough) return gait;
  switch (gaits_->stylizer->space()->Suits(gait)) {
    case Suitable::kNo:
      return MadeBy(*others_, request);
    case Suitable::kAlone:
      return gait;
    case Suitable::kYes:
      break;
  }
  return Joined(std::move(gait), MadeBy(*others_, request));
}

StyleCode SeveralSpace::MakeCode(const StyleRequest& request) const {
  if (!request.network.empty()) {
    const Member* const named = Named(request.network);
    return named == nullptr ? StyleCode() : MadeBy(*named, request);
  }
  const auto example = std::ranges::any_of(
      request.sources, [](const StyleSource& source) { return !source.reference.empty(); });
  if (example) return MadeByExample(request);
  // Styles of the list: the network of the first that has a space, else any that has variations.
  const Member* owner = others_ != nullptr ? others_ : gaits_;
  for (const StyleSource& source : request.sources) {
    if (source.style <= 0 || source.seed) continue;
    const std::size_t network = places_[static_cast<std::size_t>(source.style)].network;
    const auto found = std::find_if(members_.begin(), members_.end(), [network](const Member& one) {
      return one.network == network;
    });
    if (found == members_.end()) continue;
    owner = &*found;
    break;
  }
  return MadeBy(*owner, request);
}

// Part by part; a part that `from` lacks is left out.
StyleCode SeveralSpace::Difference(const StyleCode& code, const StyleCode& from) const {
  StyleCode difference;
  const std::vector<Part> subtracted = Split(from);
  for (const Part& part : Split(code)) {
    const auto same = std::find_if(subtracted.begin(), subtracted.end(), [&](const Part& other) {
      return other.network == part.network;
    });
    if (same == subtracted.end()) continue;
    const StyleSpace& space = *MemberOf(part.network).stylizer->space();
    difference = Joined(std::move(difference), space.Difference(part.code, same->code));
  }
  return difference;
}

StyleCode SeveralSpace::Limited(const StyleCode& code) const {
  StyleCode limited;
  for (const Part& part : Split(code)) {
    limited =
        Joined(std::move(limited), MemberOf(part.network).stylizer->space()->Limited(part.code));
  }
  return limited;
}

// Part by part; parts that only one of them has are kept. Parts stay in the order of a pair.
StyleCode SeveralSpace::Mean(const StyleCode& a, const StyleCode& b, float share) const {
  std::vector<Part> parts = Split(a);
  for (Part& other : Split(b)) {
    const auto same = std::find_if(parts.begin(), parts.end(), [&other](const Part& part) {
      return part.network == other.network;
    });
    if (same != parts.end()) {
      same->code = MemberOf(same->network).stylizer->space()->Mean(same->code, other.code, share);
      if (same->code.empty()) return {};
    } else if (gaits_ != nullptr && other.network == gaits_->network) {
      parts.insert(parts.begin(), std::move(other));
    } else {
      parts.push_back(std::move(other));
    }
  }
  StyleCode mean;
  for (const Part& part : parts) mean = Joined(std::move(mean), part.code);
  return IsCode(mean) ? mean : StyleCode();
}

StyleCode SeveralSpace::Portable(const StyleCode& code) const {
  const std::vector<Part> parts = Split(code);
  if (parts.empty()) return {};
  return MemberOf(parts.front().network).stylizer->space()->Portable(parts.front().code);
}

std::span<const Slider> SeveralSpace::sliders() const {
  return gaits_ == nullptr ? std::span<const Slider>() : gaits_->stylizer->space()->sliders();
}
std::span<const Preset> SeveralSpace::presets() const {
  return gaits_ == nullptr ? std::span<const Preset>() : gaits_->stylizer->space()->presets();
}

// Only the part of the network of gaits has sliders; another part of the code is left out.
Result<StyleCode> SeveralSpace::Design(const StyleCode& code, const SliderValues& values) const {
  if (gaits_ == nullptr) return StyleSpace::Design(code, values);
  StyleCode own;
  for (Part& part : Split(code)) {
    if (part.network == gaits_->network) own = std::move(part.code);
  }
  if (own.empty() && !code.empty()) {
    return Status::Error("the style is of a network without sliders; expected one of " +
                         gaits_->name + " or one that was made from a walk or a run");
  }
  return gaits_->stylizer->space()->Design(own, values);
}

SliderValues SeveralSpace::SlidersOf(const StyleCode& code) const {
  const std::vector<Part> parts = Split(code);
  if (parts.empty()) return {};
  return MemberOf(parts.front().network).stylizer->space()->SlidersOf(parts.front().code);
}

NearestStyle SeveralSpace::Nearest(const StyleCode& code) const {
  const std::vector<Part> parts = Split(code);
  if (parts.empty()) return {};
  const Part& first = parts.front();
  NearestStyle nearest = MemberOf(first.network).stylizer->space()->Nearest(first.code);
  if (nearest.style == 0) return nearest;
  const auto found = std::find_if(places_.begin(), places_.end(), [&](const Place& place) {
    return place.network == first.network && place.number == nearest.style;
  });
  nearest.style = static_cast<int>(found - places_.begin());
  return nearest;
}

Findings SeveralSpace::Describe(const StyleCode& code) const {
  const std::vector<Part> parts = Split(code);
  if (parts.empty()) return {};
  Findings findings =
      MemberOf(parts.front().network).stylizer->space()->Describe(parts.front().code);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    findings.found.push_back("other motion: by " + MemberOf(parts[i].network).name);
  }
  return findings;
}

}  // namespace styled::net
