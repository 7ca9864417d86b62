#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/net/stylizer.h"

namespace styled::net {

// Where a style of the list is: in which network, and its number there.
struct Place {
  std::size_t network = 0;
  int number = 0;
};

// The styles that several networks make from examples, as one space (several.h). A code is that of
// one network; or a pair, that of a network that follows gaits and, after it, that of another,
// which has the style where there is no gait. Immutable; any thread; allocates.
class SeveralSpace final : public StyleSpace {
 public:
  struct Member {
    std::size_t network;  // of the list
    std::string name;
    std::shared_ptr<const Stylizer> stylizer;  // it has a space
  };
  // `members`: in the order of the list, not empty. `places`: of the networks' own styles; `same`:
  // of each of them, the style of that name by network.
  SeveralSpace(std::vector<Member> members, std::vector<Place> places,
               std::vector<std::vector<int>> same);

  int least_frames() const noexcept override;
  bool IsCode(const StyleCode& code) const override { return !Split(code).empty(); }
  StyleCode MakeCode(const StyleRequest& request) const override;
  StyleCode Difference(const StyleCode& code, const StyleCode& from) const override;
  StyleCode Limited(const StyleCode& code) const override;
  StyleCode Mean(const StyleCode& a, const StyleCode& b, float share) const override;
  StyleCode Portable(const StyleCode& code) const override;
  std::span<const Slider> sliders() const override;
  std::span<const Preset> presets() const override;
  Result<StyleCode> Design(const StyleCode& code, const SliderValues& values) const override;
  SliderValues SlidersOf(const StyleCode& code) const override;
  NearestStyle Nearest(const StyleCode& code) const override;
  Findings Describe(const StyleCode& code) const override;

  // A code's parts by network, that of a gait first; empty: no network accepts it.
  struct Part {
    std::size_t network;
    StyleCode code;
  };
  std::vector<Part> Split(const StyleCode& code) const;

 private:
  const Member& MemberOf(std::size_t network) const;
  const Member* Named(const std::string& name) const;
  StyleCode MadeBy(const Member& member, const StyleRequest& request) const;
  StyleCode MadeByExample(const StyleRequest& request) const;

  std::vector<Member> members_;
  std::vector<Place> places_;
  std::vector<std::vector<int>> same_;
  const Member* gaits_ = nullptr;   // follows gaits
  const Member* others_ = nullptr;  // the first that does not
  std::size_t gait_size_ = 0;       // of a code of gaits_
};

}  // namespace styled::net
