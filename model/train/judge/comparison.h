#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/train/judge/parts.h"
#include "model/train/judge/report.h"

namespace styled::judge {

// Below this accuracy on real clips a judge's other figures are unreliable.
inline constexpr double kWeakJudge = 0.8;

// One judge's verdicts on a set of clips: the share of windows recognized as the target, over all
// cells, by style and by content. Shares over fewer cells have no interval.
struct JudgedShare {
  Share all;
  std::vector<Share> by_style, by_content;
};

// A set of clips, each of which should pass for its target style, before all judges.
struct Compared {
  std::string key, title;
  JudgedShare style, content;  // by Judges
  std::array<JudgedShare, kPartViewCount> parts;
};

// The same judges applied to everything that a network's figures are compared with. The manifest
// and the judges must outlive this object.
class Comparison {
 public:
  // `known` are the clips that trained the judges: a style is judged only in contents in which they
  // have a window of it.
  Comparison(const clip::Manifest& manifest, const Judges& judges, const PartJudges& parts,
             std::span<const train::TrainingClip> known);

  // Real clips of every style but neutral, the ceiling; and clips that were styled.
  Compared OfReal(std::string key, std::string title,
                  std::span<const train::TrainingClip> clips) const;
  Compared OfStyled(std::string key, std::string title, std::span<const Transferred> clips) const;

 private:
  class Counts;

  const clip::Manifest& manifest_;
  const Judges& judges_;
  const PartJudges& parts_;
  std::vector<bool> known_;  // by cell
};

// A row per judge, a column per set; the first set must be of real clips. Then, for the last set, a
// row per judge and a column per style, and per content. "-" if no window was judged.
void Print(const clip::Manifest& manifest, std::span<const Compared> sets);
// The same; null if no window was judged.
nlohmann::json ToJson(const clip::Manifest& manifest, std::span<const Compared> sets);

// A sentence per judge that recognizes less than kWeakJudge of real clips, overall or of a content.
std::vector<std::string> WeakJudges(const clip::Manifest& manifest, const Compared& real);

}  // namespace styled::judge
