// The options of stylize, and which of them exclude each other.
#include <cstdint>
#include <limits>

#include "model/clip/write.h"
#include "model/tools/number.h"
#include "model/tools/stylize.h"

namespace styled::stylize {
namespace {

constexpr double kMaxAmount = 3;  // of a variation: beyond, codes are nothing like trained ones

void AddStyleOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("-s,--style", arguments.style, "target style, STYLE or STYLE=WEIGHT");
  app.add_option("-a,--strength", arguments.strength, "0 to 1.5; 0 gives the input back")
      ->capture_default_str();
  app.add_option("-m,--mix", arguments.mix, "a further style, STYLE=WEIGHT; at most 4 in all")
      ->take_all()
      ->allow_extra_args(false);  // one value per --mix: the next word may be the input
  app.add_option(
         "-l,--like", arguments.like,
         "an example of the target style, CLIP.bvh or CLIP.bvh=WEIGHT; what is named without a "
         "weight shares equally what is left of 1 (weights of family st-gcn)")
      ->take_all()
      ->allow_extra_args(false);
  CLI::Option* const vary =
      app.add_option("--vary", arguments.vary,
                     "a variation of each style named, by this number (weights of family st-gcn)")
          ->check(Whole(0, std::numeric_limits<std::uint64_t>::max()));
  app.add_option("--amount", arguments.amount, "of the variation: 0 none, 1 as in training")
      ->check(Number(0, kMaxAmount))
      ->capture_default_str()
      ->needs(vary);
  app.add_option("--window", arguments.window,
                 "frames that are normalized together (weights of family st-gcn): auto, the whole "
                 "clip up to 20 s; whole; or overlapping windows of 8.5 s")
      ->check(CLI::IsMember({"auto", "whole", "overlapping"}))
      ->capture_default_str();
}

void AddStageOptions(CLI::App& app, Arguments& arguments) {
  app.add_flag("--absolute", arguments.absolute,
               "the paper's output instead of the detail-preserving one");
  app.add_option("--parts,--only", arguments.parts,
                 "style these parts of the body alone, comma-separated")
      ->capture_default_str();
  app.add_option("--input-style,--from", arguments.input_style,
                 "the style that the performer moves in; --style neutral removes it");
  app.add_option(
         "--root", arguments.root,
         "where on the floor: follow the performer, or stride, their way scaled by what the "
         "style does to speed")
      ->check(CLI::IsMember({"follow", "stride"}))
      ->capture_default_str();
  app.add_flag("--cadence", arguments.cadence,
               "warp time where the performer walks or runs, so that steps come as often as the "
               "style's; the length of the clip changes");
  app.add_flag("--no-bypass", arguments.no_bypass,
               "without a style, still go through bind, network and unbind");
  app.add_flag("--feet,!--no-feet", arguments.feet,
               "hold feet that the performer plants where they are (default: --feet)");
  app.add_flag("--bind-only", arguments.bind_only,
               "only bind to the canonical humanoid and back, without the network");
}

void AddFileOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("-w,--weights", arguments.weights,
                 "weights: a file, or the name of shipped ones, like st-gcn (default: v2)");
  app.add_option("--rig", arguments.rig, "rig dialect, e.g. bandai-namco, cmu")
      ->capture_default_str();
  app.add_option("--avatar", arguments.avatar,
                 "put the motion onto this skeleton: .vrm, .glb, .gltf or .bvh");
  app.add_flag("--list", arguments.list, "print the styles of the weights");
  app.add_option("in", arguments.in, "input BVH");
  app.add_option("out", arguments.out, "output file: " + clip::FormatNames())
      ->check([](const std::string& file) { return clip::FindFormat(file).status().message(); });
}

// What says something about styling or weights, and so nothing with --bind-only. Not CLI11's
// excludes(), which would write as much behind each of them in the help.
constexpr const char* kNotWithBindOnly[] = {
    "--style",     "--strength", "--mix",     "--like",        "--vary", "--amount",
    "--window",    "--absolute", "--parts",   "--input-style", "--root", "--cadence",
    "--no-bypass", "--feet",     "--weights", "--avatar"};

}  // namespace

void AddOptions(CLI::App& app, Arguments& arguments) {
  AddStyleOptions(app, arguments);
  AddStageOptions(app, arguments);
  AddFileOptions(app, arguments);
}

Status CheckTogether(const CLI::App& app, const Arguments& arguments) {
  if (!arguments.list && (arguments.in.empty() || arguments.out.empty())) {
    return Status::Error("expected an input and an output file; see --help");
  }
  for (const char* const option : kNotWithBindOnly) {
    if (arguments.bind_only && app.count(option) > 0) {
      return Status::Error(std::string("--bind-only excludes ") + option);
    }
  }
  const bool without = arguments.style.empty() && arguments.mix.empty() && arguments.like.empty();
  if (!arguments.list && !arguments.input_style.empty() && without && !arguments.no_bypass) {
    return Status::Error(
        "--input-style: expected --style, --mix or --like, found none: give "
        "--style neutral to remove " +
        arguments.input_style);
  }
  if (!arguments.list && arguments.root != "follow" && without) {
    return Status::Error("--root stride: expected a style, whose speed it takes: --style or --mix");
  }
  if (!arguments.list && arguments.cadence && without) {
    return Status::Error("--cadence: expected a style, whose steps it takes: --style or --mix");
  }
  return Status::Ok();
}

}  // namespace styled::stylize
