#pragma once

#include <vector>

#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/data.h"
#include "model/train/judge/strips.h"

namespace styled::judge {

// Pictures of the longest neutral walk of `data.validation`, restyled by a network with a space of
// styles: by one example each of four styles; by three noises in the two styles whose mean codes
// are farthest apart, with a real clip of each; between these two; and 1,000 frames of mixed acts
// by one code. Empty if the weights have fewer than two of the manifest's styles, or there is no
// walk.
std::vector<Picture> PicturesOf(const Data& data, const ClipRestyler& restyler);

}  // namespace styled::judge
