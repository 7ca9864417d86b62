#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/data.h"
#include "model/train/judge/text.h"
#include "model/train/judge/variety.h"

namespace styled::judge {

// Measures the quality of a network's space of style codes (Park et al. 2021, section 4), on the
// longest input of each content. Distances in cm, in the heading frame. NaN if not measured.
struct Variety {
  Mean distance_cm;            // average pairwise distance of outputs of one input in one style
  std::vector<Mean> by_style;  // the same; [0] is empty
  Mean recognized;             // share of their windows taken for the style: of the same outputs
  Mean content_recognized;
};
struct CodeSpace {
  Variety noise, examples;
  // Of real clips of one style and content after the best shift: the ceiling.
  Mean real_cm;
  std::vector<Mean> real_by_content;
  // Of a noise's code from the code that the network reads off its own output, over the mean
  // distance between the styles' mean codes.
  Mean consistency;
  // Of how far one noise moves a clip in two styles: rank correlation, mean over pairs of styles.
  Mean intensity;
  // Examples of one style and content: does the output follow an example's own deviation? `of_all`
  // is over the contents whose clips are one act. In a content with raises of either hand, an
  // example's mean pose mainly shows which hand was raised, which the input determines and not the
  // example.
  std::vector<Following> following;  // by content
  Following of_all;
  Mean halves;  // two halves of one example, over two examples
  // Between the mean codes of each pair of styles, on a walk (or the first content).
  int pairs = 0, monotone = 0;
  Mean quarter, half, three_quarters;  // places
  double largest_step = kNotMeasured;  // of any pair, over its mean step
};

// `count` noises, and as many examples, of each input and style.
CodeSpace MeasureCodes(const Data& data, const Judges& judges, const ClipRestyler& restyler,
                       int count);
void Print(const clip::Manifest& manifest, const CodeSpace& codes);
nlohmann::json ToJson(const clip::Manifest& manifest, const CodeSpace& codes);

}  // namespace styled::judge
