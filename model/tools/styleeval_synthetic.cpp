#include <algorithm>
#include <cstdio>

#include "model/synthetic/performer.h"
#include "model/tools/styleeval.h"

namespace styled {
namespace {

// A content, and the script with which the synthetic performer performs it.
struct Performance {
  const char* content;
  std::vector<synthetic::ScriptItem> script;
};

std::vector<Performance> Performances() {
  using enum synthetic::Motion;
  constexpr double kPause_s = 1.5;  // gestures return to rest in it
  return {{"walk", {{kWalk, 60}}},
          {"run", {{kRun, 60}}},
          {"turn", {{kTurnLeft, 6}, {kWalk, 1.5}, {kTurnRight, 6}, {kWalk, 1.5}}},
          {"raise",
           {{kRaiseLeft, 2},
            {kStand, kPause_s},
            {kRaiseRight, 2},
            {kStand, kPause_s},
            {kRaiseBoth, 2},
            {kStand, kPause_s}}},
          {"wave",
           {{kWaveLeft, 6},
            {kStand, kPause_s},
            {kWaveRight, 6},
            {kStand, kPause_s},
            {kWaveBoth, 6},
            {kStand, kPause_s}}}};
}

}  // namespace

// Counts only windows that belong to the content throughout (a pause belongs to none).
void JudgeSynthetic(EvalSession& session) {
  constexpr int kPerformers = 6;
  constexpr int kSeconds = 60;
  const std::vector<std::string>& contents = session.data.manifest.contents;
  std::printf("\nsynthetic performer, windows that the content judge recognizes\n");
  std::vector<judge::ClipVerdict> verdicts;
  for (const Performance& performance : Performances()) {
    const auto found = std::find(contents.begin(), contents.end(), performance.content);
    if (found == contents.end()) continue;
    const int content = static_cast<int>(found - contents.begin());
    const synthetic::Motion pause = performance.script.back().motion;
    const bool pauses = performance.script.size() > 1;
    std::vector<double> answers(contents.size(), 0);  // mean over judges
    for (int k = 0; k < kPerformers; ++k) {
      synthetic::Performer human(
          synthetic::Vary(1, static_cast<std::uint64_t>(k), performance.script));
      judge::Poses poses(static_cast<std::size_t>(kSeconds * judge::kJudgeRate_hz));
      std::vector<int> counted(poses.size(), 0);  // frames since the last pause
      for (std::size_t i = 0; i < poses.size(); ++i) {
        human.Pose(static_cast<double>(i) / judge::kJudgeRate_hz, poses[i]);
        const bool paused = pauses && human.motion() == pause;
        counted[i] = paused ? 0 : (i > 0 ? counted[i - 1] : 0) + 1;
      }
      const std::vector<judge::Verdicts> said = session.judges.Judge(
          judge::MakeSequence(poses, 0, content, false, session.judges.parameters()), 8);
      judge::ClipVerdict verdict{.cell = content, .clip = k};
      for (std::size_t i = 0; i < said.front().starts.size(); ++i) {
        // Frame f of the sequence is pose f + 1.
        const int window = session.judges.settings().window;
        if (counted[static_cast<std::size_t>(said.front().starts[i] + window)] < window) continue;
        std::vector<double> hits;
        for (const judge::Verdicts& of_judge : said) {
          hits.push_back(of_judge.content[i] == content ? 1 : 0);
          answers[static_cast<std::size_t>(of_judge.content[i])] +=
              1.0 / static_cast<double>(said.size());
        }
        verdict.Add(hits, 1);
      }
      verdicts.push_back(verdict);
    }
    double total = 0;
    for (const double count : answers) total += count;
    const double share = answers[static_cast<std::size_t>(content)] / std::max(1.0, total);
    std::printf("  %-6s %.3f of %4.0f:", performance.content, share, total);
    for (std::size_t i = 0; i < contents.size(); ++i) {
      std::printf("  %s %.1f", contents[i].c_str(), answers[i]);
    }
    std::printf("\n");
    session.json["synthetic"][performance.content] = {{"recognized", share}, {"windows", total}};
  }
  const judge::Share all = judge::MacroShare(verdicts, 1);
  std::printf("  mean   %s [%.3f %.3f]; on real clips %s\n", judge::Padded(all, 0, 3).c_str(),
              all.low, all.high, judge::Padded(session.evaluator.real_content(), 0, 3).c_str());
  session.json["synthetic"]["mean"] = all.value;
  session.json["synthetic"]["mean_spread"] = judge::Value(all.spread());
}

}  // namespace styled
