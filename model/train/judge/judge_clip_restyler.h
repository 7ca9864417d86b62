#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/net/clip_stylizer.h"
#include "model/train/judge/judge_restyler.h"

namespace styled::judge {

// A network of the runtime that needs whole clips, published by the same stages as live: its clips
// are styled at the stream's rate by stylist::ClipStylist.
class ClipRestyler final : public Restyler {
 public:
  // `style_of`: manifest style to network style, or kAbsent.
  ClipRestyler(std::shared_ptr<const net::ClipStylizer> network, std::vector<int> style_of,
               const stylist::Options& options, bool absolute);

  double rate_hz() const override { return kStreamRate_hz; }
  bool Has(int style) const override;
  Poses Restyle(std::span<const body::Pose> clip, const Target& target) const override;

  // The code of a target, and a clip (at kStreamRate_hz) by a code.
  net::StyleCode CodeOf(const Target& target) const;
  Poses RestyleBy(std::span<const body::Pose> clip, const net::StyleCode& code) const;
  const net::ClipStylizer& network() const { return *network_; }

 private:
  std::shared_ptr<const net::ClipStylizer> network_;
  std::vector<int> style_of_;
  stylist::Options options_;
  bool absolute_;
  std::shared_ptr<const rig::Binding> binding_;
};

// Weights of either kind of network; exactly one is set.
struct AnyStyler {
  std::optional<Styler> frames;         // runs live
  std::unique_ptr<ClipRestyler> clips;  // needs whole clips
};
// `absolute` is for clips alone: Style() asks a Styler for either form. Errors name the file.
Result<AnyStyler> LoadAnyStyler(const std::filesystem::path& weights,
                                const clip::Manifest& manifest, const stylist::Options& options,
                                bool absolute);

}  // namespace styled::judge
