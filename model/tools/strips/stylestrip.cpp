// Draws strips of stick figures: the input on top, and below it each style at the same moments. The
// figures come from the same stylist that the daemon runs, at 120 Hz.
#include <CLI/CLI.hpp>
#include <iostream>

#include "model/body/heading.h"
#include "model/clip/bind_clip.h"
#include "model/clip/clip.h"
#include "model/feet/legs.h"
#include "model/net/shipped_weights.h"
#include "model/synthetic/performer.h"
#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/tools/strips/canvas.h"
#include "model/tools/strips/figure.h"
#include "model/train/judge/stream.h"
#include "model/trial/trial.h"

namespace {

namespace body = styled::body;
namespace clip = styled::clip;
namespace judge = styled::judge;
namespace synthetic = styled::synthetic;
using judge::Poses;
using styled::Result;
using styled::Status;
using styled::strips::Canvas;
using styled::strips::kFloor;
using styled::strips::kTrunk;

constexpr int kColumn_px = 96, kRow_px = 190, kMargin_px = 14, kLabel_px = 20;
constexpr float kScale_px = 92;  // per metre
constexpr int kBlendFrames = 40;

struct Arguments {
  std::string input, weights, out, script;
  std::vector<std::string> styles;
  double start_s = 0, after_s = 0, every_s = 0.15;
  int figures = 12;
  float strength = 1;
  bool front = false, absolute = false;
  styled::stylist::Options stylist;
};

Result<Poses> LoadInput(const Arguments& arguments) {
  const double rate = judge::kStreamRate_hz;
  const double needed_s = arguments.start_s + arguments.every_s * arguments.figures;
  Poses poses;
  if (!arguments.script.empty()) {
    auto script = synthetic::ParseScript(arguments.script);
    if (!script.ok()) return script.status();
    synthetic::Options options;
    options.script = script.value();
    synthetic::Performer human(options);
    const auto frames = static_cast<std::size_t>((arguments.after_s + needed_s) * rate) + 1;
    poses.resize(frames);
    for (std::size_t i = 0; i < frames; ++i) human.Pose(static_cast<double>(i) / rate, poses[i]);
    return poses;
  }
  auto source = clip::ReadBvh(arguments.input);
  if (!source.ok()) return source.status();
  auto binding = clip::BindClip(source.value());
  if (!binding.ok()) return Status::Error(arguments.input + ": " + binding.status().message());
  poses = clip::ResamplePoses(clip::ToCanonical(source.value(), binding.value().binding),
                              source.value().rate_hz, rate);
  if (arguments.after_s > 0) {
    judge::Chain chain = judge::ChainClips({&poses, 1}, rate, arguments.after_s, kBlendFrames);
    if (chain.poses.empty()) return Status::Error(arguments.input + ": too short to be looped");
    poses = std::move(chain.poses);
  }
  return poses;
}

Status Run(const Arguments& arguments) {
  Result<Poses> input = LoadInput(arguments);
  if (!input.ok()) return input.status();
  const Poses& poses = input.value();
  const double rate = judge::kStreamRate_hz;
  const auto first = static_cast<std::size_t>((arguments.after_s + arguments.start_s) * rate);
  const auto step = static_cast<std::size_t>(arguments.every_s * rate);
  if (first + step >= poses.size()) {
    return Status::Error("the input ends before --start: it is " +
                         std::to_string(static_cast<double>(poses.size()) / rate) + " s long");
  }
  const int figures =
      std::min<int>(arguments.figures, static_cast<int>((poses.size() - 1 - first) / step) + 1);

  std::vector<std::pair<std::string, Poses>> rows = {{"input", poses}};
  if (!arguments.styles.empty()) {
    const auto weights = styled::net::FindWeights(arguments.weights);
    if (!weights.ok()) return weights.status();
    auto network = styled::trial::Load(weights.value());
    if (!network.ok()) return network.status();
    const auto binding =
        std::make_shared<const styled::rig::Binding>(styled::feet::HumanoidBinding());
    for (const std::string& style : arguments.styles) {
      const int index = styled::net::FindStyle(network.value()->model().styles, style);
      if (index < 0)
        return Status::Error(weights.value().string() + ": no style \"" + style + "\"");
      if (index == 0) {  // neutral changes nothing
        rows.emplace_back(style, poses);
        continue;
      }
      judge::Switch start{0, judge::OneStyle(index, arguments.absolute)};
      start.settings.strength = arguments.strength;
      rows.emplace_back(style, judge::StyleStream(network.value(), binding, arguments.stylist,
                                                  {&start, 1}, poses));
    }
  }

  float floor_m = 1e9F;
  body::WorldPose world;
  for (const body::Pose& pose : poses) {
    body::ForwardKinematics(pose, world);
    floor_m = std::min(floor_m, body::LowestFoot_m(world));
  }
  const int width = 2 * kMargin_px + figures * kColumn_px;
  const int row_px = kRow_px + kLabel_px;
  Canvas canvas(width, static_cast<int>(rows.size()) * row_px + kMargin_px);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const float top = static_cast<float>(row) * row_px;
    const float floor_px = top + row_px - 4;
    canvas.Text(kMargin_px, top + 8, rows[row].first, 2, kTrunk);
    canvas.Line(kMargin_px, floor_px + 2, static_cast<float>(width - kMargin_px), floor_px + 2, 1,
                kFloor);
    for (int i = 0; i < figures; ++i) {
      const std::size_t frame = first + static_cast<std::size_t>(i) * step;
      // All rows share the input's heading, so that they can be compared.
      body::ForwardKinematics(poses[frame], world);
      styled::strips::Place place{kMargin_px + (static_cast<float>(i) + 0.5F) * kColumn_px,
                                  floor_px, kScale_px, body::Heading_rad(world),
                                  arguments.front ? 0.0F : styled::strips::kFromTheRight_rad};
      place.floor_m = floor_m;
      styled::strips::DrawFigure(rows[row].second[frame], place, canvas);
    }
  }
  return canvas.WritePng(arguments.out);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Draws strips of stick figures: the input, and below it each style.");
  app.add_option("input", arguments.input, "BVH file");
  app.add_option("--synthetic", arguments.script,
                 "Instead of a file, the synthetic performer by this script, e.g. walk:5");
  app.add_option("--weights", arguments.weights,
                 "Weights: a file, or the name of shipped ones (default: v2)");
  app.add_option("--style", arguments.styles, "A row in this style; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--strength", arguments.strength, "Of the styles")
      ->check(styled::Number(0, 1.5))
      ->capture_default_str();
  app.add_option("-o,--out", arguments.out, "PNG to write")->required();
  app.add_option("--start", arguments.start_s, "First figure, seconds")
      ->check(styled::Number(0, 86400))
      ->capture_default_str();
  app.add_option("--after", arguments.after_s,
                 "Seconds streamed before (the clip is looped, its path continued)")
      ->check(styled::Number(0, 86400))
      ->capture_default_str();
  app.add_option("--every", arguments.every_s, "Seconds between figures")
      ->check(styled::Number(0.01, 3600))
      ->capture_default_str();
  app.add_option("--figures", arguments.figures, "Figures per row")
      ->check(styled::Number(1, 1000))
      ->capture_default_str();
  app.add_flag("--front", arguments.front, "Seen from the front, not from the right");
  app.add_flag("!--no-neutral", arguments.stylist.neutral,
               "Do not remove the performer's own carriage before the network");
  app.add_option("--posture", arguments.stylist.posture,
                 "How much of a style's posture is kept while the network shows none of it")
      ->check(styled::Number(0, 1))
      ->capture_default_str();
  app.add_flag("!--no-limb-gate", arguments.stylist.limb_gate,
               "Do not withhold the style of limbs in unknown motions");
  app.add_flag("--absolute", arguments.absolute, "The paper's absolute output");
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  if (arguments.input.empty() == arguments.script.empty()) {
    std::cerr << "stylestrip: give either a BVH file or --synthetic\n";
    return 2;
  }
  const Status status = Run(arguments);
  if (status.ok()) return 0;
  std::cerr << "stylestrip: " << status.message() << "\n";
  return 1;
}
