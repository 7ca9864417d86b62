#include "model/train/judge/comparison.h"

#include <algorithm>
#include <cstdio>

#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr std::size_t kSetWidth = 22;   // characters of "0.72 ±0.03 [0.70 0.75]"
constexpr std::size_t kCellWidth = 10;  // of "0.72 ±0.03"

// Every judge of a set, in the order of the table.
struct Row {
  std::string key, title;
  const JudgedShare& share;
};

std::vector<Row> Rows(const Compared& set) {
  std::vector<Row> rows{{"style", "style (SRA)", set.style},
                        {"content", "content (CRA)", set.content}};
  for (std::size_t i = 0; i < kPartViewCount; ++i) {
    const PartView& view = PartViews()[i];
    rows.push_back({std::string(view.key), std::string(view.title), set.parts[i]});
  }
  return rows;
}

std::string Text(const Share& share) { return Padded(share, 0, 2); }

// With the interval over clips.
std::string WithInterval(const Share& share) {
  if (share.windows <= 0) return "-";
  char text[32];
  std::snprintf(text, sizeof text, " [%.2f %.2f]", share.low, share.high);
  return Text(share) + text;
}

// Right-aligned; "±" counts as one character.
std::string Right(const std::string& text, std::size_t width) {
  const auto characters = static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
  return std::string(width - std::min(width, characters), ' ') + text;
}

}  // namespace

// The verdicts of every judge on the clips of one set.
class Comparison::Counts {
 public:
  explicit Counts(const Comparison& of) : of_(of) {}

  void Add(std::span<const body::Pose> poses, int clip, int style, int content) {
    const int cell = style * static_cast<int>(of_.manifest_.contents.size()) + content;
    const auto verdict = [&](const std::vector<double>& hits, std::size_t windows) {
      ClipVerdict of_clip{.cell = cell, .clip = clip};
      of_clip.Add(hits, static_cast<double>(windows));
      return of_clip;
    };
    const std::vector<Verdicts> whole = of_.judges_.Judge(
        MakeSequence(poses, style, content, false, of_.judges_.parameters()), kStride);
    const std::size_t windows = whole.front().starts.size();
    contents_.push_back(verdict(Hits(whole, &Verdicts::content, content), windows));
    if (!of_.known_[static_cast<std::size_t>(cell)]) return;
    styles_.push_back(verdict(Hits(whole, &Verdicts::style, style), windows));
    const std::vector<PartJudges::Answers> parts = of_.parts_.Judge(poses, kStride);
    for (std::size_t i = 0; i < kPartViewCount; ++i) {
      std::vector<double> hits;
      for (const PartJudges::Answers& judge : parts) {
        hits.push_back(static_cast<double>(std::count(judge[i].begin(), judge[i].end(), style)));
      }
      parts_[i].push_back(verdict(hits, parts.front()[i].size()));
    }
  }

  void Finish(Compared& set) const {
    set.style = Shares(styles_);
    set.content = Shares(contents_);
    for (std::size_t i = 0; i < kPartViewCount; ++i) set.parts[i] = Shares(parts_[i]);
  }

 private:
  JudgedShare Shares(const std::vector<ClipVerdict>& verdicts) const {
    const int contents = static_cast<int>(of_.manifest_.contents.size());
    JudgedShare shares{
        .all = MacroShare(verdicts, kIntervalSeed), .by_style = {}, .by_content = {}};
    const auto of = [&verdicts](const auto& wanted) {
      std::vector<ClipVerdict> some;
      std::copy_if(verdicts.begin(), verdicts.end(), std::back_inserter(some), wanted);
      return MacroShare(some, kIntervalSeed, 0);
    };
    for (int style = 0; style < static_cast<int>(of_.manifest_.styles.size()); ++style) {
      shares.by_style.push_back(
          of([=](const ClipVerdict& verdict) { return verdict.cell / contents == style; }));
    }
    for (int content = 0; content < contents; ++content) {
      shares.by_content.push_back(
          of([=](const ClipVerdict& verdict) { return verdict.cell % contents == content; }));
    }
    return shares;
  }

  const Comparison& of_;
  std::vector<ClipVerdict> styles_, contents_;
  std::array<std::vector<ClipVerdict>, kPartViewCount> parts_;
};

Comparison::Comparison(const clip::Manifest& manifest, const Judges& judges,
                       const PartJudges& parts, std::span<const train::TrainingClip> known)
    : manifest_(manifest),
      judges_(judges),
      parts_(parts),
      known_(manifest.styles.size() * manifest.contents.size(), false) {
  for (const train::TrainingClip& clip : known) {
    // The features of a clip begin with its second frame.
    if (static_cast<int>(clip.poses.size()) <= judges.settings().window) continue;
    known_[static_cast<std::size_t>(clip.style) * manifest.contents.size() +
           static_cast<std::size_t>(clip.content)] = true;
  }
}

Compared Comparison::OfReal(std::string key, std::string title,
                            std::span<const train::TrainingClip> clips) const {
  Counts counts(*this);
  for (std::size_t i = 0; i < clips.size(); ++i) {
    if (clips[i].style == 0) continue;
    counts.Add(clips[i].poses, static_cast<int>(i), clips[i].style, clips[i].content);
  }
  Compared set{
      .key = std::move(key), .title = std::move(title), .style = {}, .content = {}, .parts = {}};
  counts.Finish(set);
  return set;
}

Compared Comparison::OfStyled(std::string key, std::string title,
                              std::span<const Transferred> clips) const {
  Counts counts(*this);
  for (const Transferred& clip : clips) {
    counts.Add(Thin(clip.output), clip.clip, clip.style, clip.content);
  }
  Compared set{
      .key = std::move(key), .title = std::move(title), .style = {}, .content = {}, .parts = {}};
  counts.Finish(set);
  return set;
}

std::vector<std::string> WeakJudges(const clip::Manifest& manifest, const Compared& real) {
  std::vector<std::string> weak;
  for (const Row& row : Rows(real)) {
    const auto is_weak = [](const Share& share) {
      return share.windows > 0 && share.value < kWeakJudge;
    };
    std::string where;
    for (std::size_t c = 0; c < row.share.by_content.size(); ++c) {
      if (!is_weak(row.share.by_content[c])) continue;
      where += (where.empty() ? ", of " : ", ") + manifest.contents[c] + " " +
               Text(row.share.by_content[c]);
    }
    if (where.empty() && !is_weak(row.share.all)) continue;
    weak.push_back(row.title + ": the judge recognizes " + Text(row.share.all) + " of real clips" +
                   where + "; its figures there are unreliable");
  }
  return weak;
}

void Print(const clip::Manifest& manifest, std::span<const Compared> sets) {
  std::vector<std::vector<Row>> columns;
  for (const Compared& set : sets) columns.push_back(Rows(set));
  std::printf(
      "\nshare of windows that each judge takes for the target (content: for the input's); ± over "
      "the judges' seeds, 95 %% over clips\n%-18s",
      "");
  for (const Compared& set : sets) std::printf(" %s", Right(set.title, kSetWidth).c_str());
  std::printf("  windows\n");
  for (std::size_t i = 0; i < columns.front().size(); ++i) {
    std::printf("%-18s", columns.front()[i].title.c_str());
    for (const std::vector<Row>& column : columns) {
      std::printf(" %s", Right(WithInterval(column[i].share.all), kSetWidth).c_str());
    }
    std::printf("  %.0f\n", columns.back()[i].share.all.windows);
  }
  for (const std::string& weak : WeakJudges(manifest, sets.front()))
    std::printf("warning: %s\n", weak.c_str());

  std::printf("\n%s, by style and by content\n%-18s", sets.back().title.c_str(), "");
  for (std::size_t s = 1; s < manifest.styles.size(); ++s) {
    std::printf(" %s", Right(manifest.styles[s].name, kCellWidth).c_str());
  }
  std::printf("  ");
  for (const std::string& content : manifest.contents)
    std::printf(" %s", Right(content, kCellWidth).c_str());
  std::printf("\n");
  for (const Row& row : columns.back()) {
    std::printf("%-18s", row.title.c_str());
    for (std::size_t s = 1; s < row.share.by_style.size(); ++s) {
      std::printf(" %s", Right(Text(row.share.by_style[s]), kCellWidth).c_str());
    }
    std::printf("  ");
    for (const Share& share : row.share.by_content) {
      std::printf(" %s", Right(Text(share), kCellWidth).c_str());
    }
    std::printf("\n");
  }
}

nlohmann::json ToJson(const clip::Manifest& manifest, std::span<const Compared> sets) {
  nlohmann::json json = nlohmann::json::array();
  for (const Compared& set : sets) {
    nlohmann::json judges = nlohmann::json::array();
    for (const Row& row : Rows(set)) {
      nlohmann::json one = {{"key", row.key},
                            {"title", row.title},
                            {"value", Value(Measured(row.share.all))},
                            {"spread", Value(row.share.all.spread())},
                            {"low", row.share.all.low},
                            {"high", row.share.all.high},
                            {"windows", row.share.all.windows}};
      for (std::size_t s = 1; s < row.share.by_style.size(); ++s) {
        const Share& of = row.share.by_style[s];
        one["styles"][manifest.styles[s].name] = Value(Measured(of));
        one["styles_spread"][manifest.styles[s].name] = Value(of.spread());
      }
      for (std::size_t c = 0; c < row.share.by_content.size(); ++c) {
        const Share& of = row.share.by_content[c];
        one["contents"][manifest.contents[c]] = Value(Measured(of));
        one["contents_spread"][manifest.contents[c]] = Value(of.spread());
      }
      judges.push_back(std::move(one));
    }
    json.push_back({{"key", set.key}, {"title", set.title}, {"judges", std::move(judges)}});
  }
  return json;
}

}  // namespace styled::judge
