#include "model/train/judge/long.h"

#include <algorithm>

#include "model/clip/clip.h"

namespace styled::judge {
namespace {

constexpr int kBlendFrames = 10;  // overlap of chained clips, at the judges' rate

// One style for all of a run, and the network gets the content of each clip as it begins.
std::vector<Switch> SwitchesOf(const Styler& styler, int style, const LongRun& run) {
  std::vector<Switch> switches{{0, OneStyle(style, false)}};
  if (styler.content_of.empty()) return switches;
  switches.clear();
  for (const Chain::Part& part : run.chain.parts) {
    Switch& next = switches.emplace_back(Switch{part.begin, OneStyle(style, false)});
    next.settings.input_content =
        styler.ContentOf(run.contents[static_cast<std::size_t>(part.clip)]);
  }
  return switches;
}

LongRun RunOne(const Styler& styler, const stylist::Options& options, double seconds,
               const std::vector<const train::TrainingClip*>& neutral) {
  std::vector<Poses> clips;
  LongRun run;
  for (const train::TrainingClip* c : neutral) {
    clips.push_back(c->poses);
    run.contents.push_back(c->content);
  }
  run.chain = ChainClips(clips, kJudgeRate_hz, seconds, kBlendFrames);
  if (run.chain.poses.empty()) return run;
  run.chain.poses = clip::ResamplePoses(run.chain.poses, kJudgeRate_hz, kStreamRate_hz);
  for (Chain::Part& part : run.chain.parts) {
    part.begin *= kStreamPerJudge;
    part.end = std::min(part.end * kStreamPerJudge, run.chain.poses.size());
  }
  for (const int style : styler.style_of) {
    run.styled.push_back(style == kAbsent
                             ? Poses()
                             : StyleStream(styler.network, styler.binding, options,
                                           SwitchesOf(styler, style, run), run.chain.poses));
  }
  return run;
}

}  // namespace

std::vector<LongRun> RunLong(const Data& data, const Styler& styler,
                             const stylist::Options& options, double seconds) {
  std::vector<std::vector<const train::TrainingClip*>> by_content(data.manifest.contents.size());
  std::size_t most = 0;
  for (const train::TrainingClip& c : data.validation) {
    if (c.style != 0) continue;
    auto& clips = by_content[static_cast<std::size_t>(c.content)];
    clips.push_back(&c);
    most = std::max(most, clips.size());
  }
  std::vector<const train::TrainingClip*> mixed;
  for (std::size_t i = 0; i < most; ++i) {
    for (const auto& clips : by_content) {
      if (i < clips.size()) mixed.push_back(clips[i]);
    }
  }
  std::vector<LongRun> runs;
  for (const auto& clips : by_content) {
    LongRun run = RunOne(styler, options, seconds, clips);
    if (!run.chain.poses.empty()) runs.push_back(std::move(run));
  }
  runs.push_back(RunOne(styler, options, seconds, mixed));
  return runs;
}

std::vector<Transferred> CutLate(std::span<const LongRun> runs, double seconds) {
  std::vector<Transferred> late;
  const auto from = static_cast<std::size_t>(seconds * kStreamRate_hz);
  int clip = 0;
  for (const LongRun& run : runs) {
    for (const Chain::Part& part : run.chain.parts) {
      if (part.begin < from || part.end <= part.begin) continue;
      const auto cut = [&part](const Poses& poses) {
        return std::span(poses).subspan(part.begin, part.end - part.begin);
      };
      for (std::size_t style = 1; style < run.styled.size(); ++style) {
        if (run.styled[style].empty()) continue;
        const auto styled = cut(run.styled[style]);
        late.push_back({clip, static_cast<int>(style),
                        run.contents[static_cast<std::size_t>(part.clip)], cut(run.chain.poses),
                        Poses(styled.begin(), styled.end())});
      }
      ++clip;
    }
  }
  return late;
}

}  // namespace styled::judge
