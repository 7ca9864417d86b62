#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/train/judge/comparison.h"
#include "model/train/judge/data.h"
#include "model/train/judge/html.h"
#include "model/train/judge/report.h"
#include "model/train/judge/strips.h"

// Declarations that the sources of styleeval share.
namespace styled {

struct EvalArguments {
  std::string weights, examples, manifest, inputs, data, cache, json, report, write_offset;
  std::string judges_file, write_judges;                   // instead of training; only train
  std::string split = judge::kValidation, ledger, commit;  // the latter two: of a test
  bool again = false;
  double long_s = 60;
  bool long_given = false, transition_given = false;  // on the command line
  double clip_rate_hz = judge::kStreamRate_hz;
  std::string precision = "int8";
  bool write_evidence = false;
  bool absolute = false, synthetic = false, robust = false, rates = false, styled_inputs = false,
       foreign = false;
  std::vector<std::filesystem::path> clips;
  judge::JudgeSettings judges = {.count = judge::kUsualJudges};
  int action_classifiers = 0;
  stylist::Options stylist;
  std::string root = "follow";  // or "stride": stylist::Root
  std::string contents = "recognized";
  float transition_s = net::kUsualTransition_s;
};

// The judges of one call, and their results so far. Everything that it refers to outlives it.
struct EvalSession {
  const EvalArguments& arguments;
  const judge::Data& data;
  const judge::Judges& judges;
  const judge::Evaluator& evaluator;
  nlohmann::json json;
  std::vector<judge::Scene> scenes;
  std::vector<judge::Picture> pictures = {};
};

// Measures, prints and records the clips under `key`, unless none is as long as a window. `offset`:
// the constant offset's figures on the same inputs; null: they are measured.
void Report(EvalSession& session, const char* key, const std::string& title,
            const std::vector<judge::Transferred>& clips, const judge::Figures* offset = nullptr);

// Weights that run live, under every condition that the arguments request; styleeval_live.cpp. The
// ordinary condition, clip by clip, is judged before.
Status JudgeConditions(EvalSession& session, const judge::Styler& styler);

// Does the content judge, trained on real clips, recognize the synthetic performer?
// styleeval_synthetic.cpp
void JudgeSynthetic(EvalSession& session);

}  // namespace styled
