#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/net/clip_stylizer.h"
#include "model/net/kernels/kernel.h"
#include "model/train/judge/restyler.h"

namespace styled::judge {

// How a network that needs whole clips is published.
struct ClipForm {
  // Of the clips: at kStreamRate_hz four streams are interleaved, as live; at kJudgeRate_hz, the
  // rate at which they were recorded, there is one. The absolute output of interleaved streams
  // trembles.
  double rate_hz = kStreamRate_hz;
  bool absolute = false;
};

// A network of the runtime that needs whole clips, published by the same stages as live, by
// stylist::ClipStylist.
class ClipRestyler final : public Restyler {
 public:
  // `style_of`: manifest style to network style, or kAbsent.
  ClipRestyler(std::shared_ptr<const net::ClipStylizer> network, std::vector<int> style_of,
               const stylist::Options& options, const ClipForm& form);

  double rate_hz() const override { return form_.rate_hz; }
  bool Has(int style) const override;
  Poses Restyle(std::span<const body::Pose> clip, const Target& target) const override;

  // The code of a target, and a clip (at rate_hz()) by a code.
  net::StyleCode CodeOf(const Target& target) const;
  Poses RestyleBy(std::span<const body::Pose> clip, const net::StyleCode& code) const;
  const net::ClipStylizer& network() const { return *network_; }

 private:
  std::shared_ptr<const net::ClipStylizer> network_;
  std::vector<int> style_of_;
  stylist::Options options_;
  ClipForm form_;
  std::shared_ptr<const rig::Binding> binding_;
};

// Weights of either kind of network; exactly one is set.
struct AnyStyler {
  std::optional<Styler> frames;         // runs live
  std::unique_ptr<ClipRestyler> clips;  // needs whole clips
};
// `form` is for clips alone: Style() asks a Styler for either output. Errors name the file.
Result<AnyStyler> LoadAnyStyler(const std::filesystem::path& weights,
                                const clip::Manifest& manifest, const stylist::Options& options,
                                const ClipForm& form,
                                net::Precision precision = net::Precision::kFloat32);

}  // namespace styled::judge
