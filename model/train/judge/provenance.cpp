#include "model/train/judge/provenance.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string_view>

#include "model/net/sha256.h"
#include "model/train/judge/examples.h"
#include "model/train/judge/sha256.h"

namespace styled::judge {
namespace {

struct Term {
  std::string_view term, meaning;
};

constexpr std::array kGlossary{
    Term{"SRA",
         "style recognition accuracy: share of windows (by default 32 frames at 30 Hz) that the "
         "style "
         "judge takes for the target; mean over cells, 95 % interval over clips"},
    Term{"CRA",
         "content recognition accuracy: share of windows in which the content judge still "
         "recognizes the performer's content"},
    Term{"judges, ±",
         "judges that differ in their seed alone: a figure is their mean, after ± their standard "
         "deviation; the interval is over clips and does not contain it"},
    Term{"cell", "one style in one content"},
    Term{"movement",
         "a style judge of joint positions less their mean over the window, which no "
         "constant offset can pass for"},
    Term{"legs, arms, trunk",
         "style judges of these joints alone, legs and trunk from the hips, "
         "arms from the chest: by pose, or by movement as above"},
    Term{"real clips",
         "the same judges on recorded clips of the target: the most that can be "
         "reached"},
    Term{"neutral input",
         "the same judges on the clips to be styled: the result of a network that "
         "does nothing"},
    Term{"constant offset",
         "each joint turned by the style's mean difference from neutral: the "
         "baseline"},
    Term{"offset per content",
         "the same for each content alone, which a live system does not "
         "know: the baseline to beat"},
    Term{"absolute",
         "the network's output itself, as in the paper; the other form, detail-preserving, applies "
         "the network's change of style to the input"},
    Term{"expression",
         "the mean change of pose along the real change, 1 is the target's; its "
         "cosine is that of the angle between the two"},
    Term{"FMD",
         "Frechet motion distance: between windows of the output and of real clips, by the "
         "features of an auto-encoder of rotations; beside it between two real halves, and "
         "from neutral"},
    Term{"FMD-c", "the same by the content judge's pooled features (Park et al. 2021)"},
    Term{"jerk",
         "the third derivative of joint positions over the input's; of a table's means "
         "over all clips, or the mean and the worst of the clips' own ratios"},
    Term{"skate", "speed of planted feet over the floor, input > output"},
    Term{"below floor",
         "how far the lowest foot is under the lowest point that the input's feet reach, 0 above "
         "it: mean over time; deepest: the most"},
    Term{"bob", "rise and fall of the hips within two steps"},
    Term{"step", "distance of the ankles along the heading when they are farthest apart"},
    Term{"knee", "bend of the knees, 0 is straight: least, and mean over time"},
    Term{"arm swing", "range of a hand along the heading, from the hips, within two steps"},
    Term{"reach",
         "how far the hand of the fastest gesture reaches in the input's direction, over "
         "the input's; off: the angle between the two arms"},
    Term{"kick", "the greatest height of a foot ahead of the body, over the input's"},
    Term{"mean code, noise, examples",
         "the source of the style code for a network with a space of styles: the style's mean "
         "code, a code "
         "drawn at random in the style, or a clip of it"},
    Term{"APD",
         "average pairwise distance of joints between outputs of one input in one style, cm: "
         "variety, meaningful only if the same outputs are recognized"},
    Term{"read off",
         "the code that the network reads off its own output, from the code that made it, over the "
         "mean distance between the styles' mean codes: 0 is the same code"},
    Term{"strength",
         "how far one noise moves a clip in one style, and in another: rank correlation over "
         "noises, mean over pairs of styles"},
    Term{"slope, cosine",
         "how far the output moves along an example's own deviation from other "
         "examples of the style: 1 is as far as the example, 0 is a network that uses the label "
         "alone"},
    Term{"halves",
         "distance of the outputs by two halves of one example over that by two examples: below 1 "
         "if examples are distinguished"},
    Term{"monotone",
         "pairs of styles between whose mean codes the output never steps back; places on the way "
         "at 1/4, 1/2, 3/4, and the largest step over the mean one"},
    Term{"mixed acts",
         "a clip in which the performer walks, turns, waves and runs without a pause, styled as a "
         "whole by each style's mean code; beside it the same frames, each act styled alone: the "
         "difference is the loss of acts in one clip"},
    Term{"taken for", "the style judge's results for the windows of a style"},
    Term{"seen after",
         "time from a change of style until the style judge takes the last frames for the new one; "
         "an instant cut: the same where the output changes at once, the judge's own delay; never: "
         "not before the next change"},
    Term{"p90, p99.9", "the bound that 90 and 99.9 % of all values do not exceed"},
    Term{"to blame",
         "share of changes of style, or of clips with the feet stage, in which the largest "
         "acceleration of a joint is over 1.5 times the input's p99.9 and well over its value "
         "without the change or the stage"},
    Term{"turn", "the largest rotation of one joint between two frames, degrees"},
    Term{"error of rec", "angle between the input and the network's own reconstruction of it"},
    Term{"flagged", "share of frames in a posture that is recognized as unlike the training data"},
    Term{"-", "not measured"},
};

}  // namespace

std::string CommandLine(int argc, char** argv) {
  std::string command = std::filesystem::path(argv[0]).filename().string();
  for (int i = 1; i < argc; ++i) command.append(" ").append(argv[i]);
  return command;
}

Status WriteJson(const nlohmann::json& json, const std::filesystem::path& file) {
  std::ofstream out(file);
  out << json.dump(2) << "\n";
  return out.flush() ? Status::Ok() : Status::Error(file.string() + ": cannot be written");
}

nlohmann::json JudgesOf(const Panel& panel) {
  nlohmann::json json = {{"sha256", panel.hash}};
  for (const char* const key :
       {"manifest", "seed", "count", "iterations", "batch", "window", "recipes", "clips"}) {
    json[key] = panel.header[key];
  }
  return json;
}

void PrintJudges(const nlohmann::json& judges) {
  const auto seed = judges["seed"].get<unsigned>();
  const auto count = judges["count"].get<unsigned>();
  std::printf("judges: SHA-256 %s, seeds %u to %u, %d iterations of %d windows of %d frames\n",
              Shown(judges["sha256"].get<std::string>()).c_str(), seed, seed + count - 1,
              judges["iterations"].get<int>(), judges["batch"].get<int>(),
              judges["window"].get<int>());
}

nlohmann::json WeightsOf(const std::string& weights) {
  std::string names;
  std::string hashes;
  const auto files = JoinedFiles(weights);
  if (!files.ok()) return {{"file", weights}, {"sha256", nullptr}};
  for (const std::filesystem::path& file : files.value()) {
    const auto hash = net::Sha256OfFile(file);
    names.append(names.empty() ? "" : "+").append(file.filename().string());
    hashes.append(hashes.empty() ? "" : "+").append(hash.ok() ? hash.value() : "unreadable");
  }
  return {{"file", names}, {"sha256", hashes}};
}

void PrintWeights(const nlohmann::json& weights) {
  std::string shown;  // each hash of joined files
  std::istringstream hashes(weights["sha256"].is_string() ? weights["sha256"].get<std::string>()
                                                          : "not read");
  for (std::string hash; std::getline(hashes, hash, '+');) {
    shown.append(shown.empty() ? "" : "+").append(Shown(hash));
  }
  std::printf("weights: %s, SHA-256 %s\n", weights["file"].get<std::string>().c_str(),
              shown.c_str());
}

nlohmann::json Provenance(const std::string& command, const Data& data, const Panel& panel,
                          const std::string& weights) {
  nlohmann::json json = {{"command", command},
                         {"manifest", data.manifest.name},
                         {"split", data.split},
                         {"judges", JudgesOf(panel)},
                         {"data",
                          {{"train", OfClips(data.train)},
                           {"judge", OfClips(data.judge)},
                           {data.split, OfClips(data.validation)}}},
                         {"inputs", data.inputs.size()}};
  if (!weights.empty()) json["weights"] = WeightsOf(weights);
  return json;
}

void PrintProvenance(const nlohmann::json& provenance) {
  std::printf("%s\n", provenance["command"].get<std::string>().c_str());
  PrintJudges(provenance["judges"]);
  if (provenance.contains("weights")) PrintWeights(provenance["weights"]);
  const auto split = [&](const std::string& name, const char* purpose) {
    const nlohmann::json& of = provenance["data"][name];
    std::printf("data: %5zu clips %s, %6zu frames, hash %s\n", of["clips"].get<std::size_t>(),
                purpose, of["frames"].get<std::size_t>(), of["hash"].get<std::string>().c_str());
  };
  const auto judged = provenance["split"].get<std::string>();
  split("train", "train the generator");
  split("judge", "train the judges");
  split(judged, ("are judged (" + judged + ")").c_str());
  std::printf("%zu inputs\n", provenance["inputs"].get<std::size_t>());
}

nlohmann::json Glossary() {
  nlohmann::json json = nlohmann::json::array();
  for (const Term& term : kGlossary) json.push_back({term.term, term.meaning});
  return json;
}

void PrintGlossary() {
  std::printf("\nglossary\n");
  for (const Term& term : kGlossary) {
    std::printf("  %-18s %s\n", std::string(term.term).c_str(), std::string(term.meaning).c_str());
  }
}

}  // namespace styled::judge
