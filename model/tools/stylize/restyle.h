#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/avatar.h"
#include "model/clip/clip.h"
#include "model/net/load.h"
#include "model/rig/binding.h"
#include "model/stylist/clip_stylist.h"
#include "model/stylist/settings.h"
#include "model/stylist/stylist.h"
#include "model/stylist/visible.h"
#include "model/tools/stylize/stylize.h"

namespace styled::stylize {

// The figures of a clip's frames.
struct Styled {
  std::size_t failed = 0;         // could not be styled and are the performer's own
  std::size_t planted = 0;        // the performer has a foot planted
  std::size_t out_of_domain = 0;  // unlike what the network was trained on
  // The mean speed over the floor of feet that stand in the input, on the humanoid, styled and in
  // the input.
  double slide_cm_s = 0, input_slide_cm_s = 0;
  // The angle by which the style turns a joint, mean of all frames (stylist::Output).
  double turned_deg = 0;
  // The distance by which it moves limbs, mean of all frames, cm (stylist::MovedBy).
  std::array<double, stylist::kVisibleLimbs.size()> moved_cm{};
  // The input's seconds, and those in which much style was requested and none of it is visible
  // (stylist::IsUnseen).
  int seconds = 0, unseen_s = 0;
  // By stylist::Limb: the mean share of the style that it shows. The rest is withheld, because the
  // network does not know the limb's motion.
  std::array<double, stylist::kLimbCount> shown{};
  bool can_stride = false;  // the weights know what --root stride needs, and it was not requested
  std::vector<double> times_s;  // of each frame, where time passes at the style's cadence
};

// The weights that the arguments name, after their trial.
Result<net::AnyStylizer> LoadNetwork(const Arguments& arguments);
// Its space of styles; null: none.
const net::StyleSpace* SpaceOf(const net::AnyStylizer& network);

// Called with the share of a clip that is done.
using Progress = std::function<void(double)>;

// The styling that the arguments and the network's kind request, for any number of clips.
class Restyler {
 public:
  // `arguments` name one style; `examples` are those of --like, `neutral` the result of the file of
  // --neutral. Reads no file. Errors name the option.
  static Result<Restyler> Make(const Arguments& arguments, const Examples& examples,
                               const std::optional<neutral::Known>& neutral,
                               const net::AnyStylizer& network);

  // Styles `clip` in place. With `avatar` its frames are then the avatar's, while the skeleton is
  // the performer's still. `file`, for errors, is the clip's. `progress` may be empty.
  Result<Styled> Run(const std::string& file, const std::shared_ptr<const rig::Binding>& binding,
                     const clip::AvatarSkeleton* avatar, const Progress& progress,
                     clip::Clip& clip) const;

 private:
  Restyler() = default;
  bool RequestsVisibleStyle() const;
  std::optional<neutral::Known> NeutralOf(const clip::Clip& clip,
                                          const rig::Binding& binding) const;

  net::AnyStylizer network_;
  bool neutral_of_clip_ = false;
  std::optional<neutral::Known> neutral_;  // of a file
  stylist::Options options_;
  stylist::Settings settings_;     // of a network that styles frame by frame
  stylist::ClipStyle clip_style_;  // of one that needs whole clips
  bool can_stride_ = false;
};

}  // namespace styled::stylize
