// The options of stylize, and which of them exclude each other.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "model/clip/bind_clip.h"
#include "model/clip/write.h"
#include "model/tools/number.h"
#include "model/tools/stylize/files.h"
#include "model/tools/stylize/stylize.h"

namespace styled::stylize {
namespace {

constexpr double kMaxAmount = 3;  // of a variation: beyond, codes are nothing like trained ones

void AddStyleOptions(CLI::App& app, Arguments& arguments) {
  app.add_option(
         "-s,--style", arguments.styles,
         "target style, STYLE or STYLE=WEIGHT; several, each into a file of its own: again, or "
         "with commas")
      ->take_all()
      ->allow_extra_args(false)
      ->delimiter(',');
  app.add_option("-a,--strength", arguments.strength, "0 to 1.5; 0 returns the input")
      ->capture_default_str();
  app.add_option("-m,--mix", arguments.mix, "an additional style, STYLE=WEIGHT; at most 4 in total")
      ->take_all()
      ->allow_extra_args(false);  // one value per --mix: the next word may be the input
  app.add_option(
         "-l,--like", arguments.like,
         "an example of the target style, CLIP or CLIP=WEIGHT: BVH, .glb or .vrma; of one longer "
         "than 60 s the first 60 s; those without a "
         "weight share the rest of 1 equally (weights of family phase, for walks and runs; "
         "or of st-gcn)")
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--like-neutral", arguments.like_neutral,
                 "a clip of the example's performer without the style: only the difference is "
                 "used, without their own way of moving")
      ->needs("--like");
  app.add_option("--design", arguments.design,
                 "a style by hand: sneaky, drunk, robot, proud, scared, cold, or "
                 "SLIDER=NUMBER,SLIDER=NUMBER,...; with --like or --style, on top of it (weights "
                 "of family phase)");
  CLI::Option* const vary =
      app.add_option("--vary", arguments.vary,
                     "the variation of this number of each named style (weights of family st-gcn)")
          ->check(Whole(0, std::numeric_limits<std::uint64_t>::max()));
  app.add_option("--amount", arguments.amount, "amount of the variation: 0 none, 1 as in training")
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
                 "style only these parts of the body, comma-separated")
      ->capture_default_str();
  app.add_option("--input-style,--from", arguments.input_style,
                 "the performer's own style; --style neutral removes it");
  app.add_option("--content", arguments.content,
                 "the content of the motion, for weights that take it as input: one of theirs, "
                 "or unknown (default: the network recognizes it)");
  app.add_option("--root", arguments.root,
                 "place on the floor: follow the performer, or stride, their path scaled by the "
                 "style's effect on speed")
      ->check(CLI::IsMember({"follow", "stride"}))
      ->capture_default_str();
  app.add_flag("--cadence", arguments.cadence,
               "warp time while the performer walks or runs, so that steps come as often as the "
               "style's; the length of the clip changes");
  app.add_option("--neutral", arguments.neutral,
                 "the performer's own posture and walk: clip, learned "
                 "from all of the clip; live, from its frames so far, as in a live stream; none; "
                 "or a clip of the same performer")
      ->capture_default_str();
  app.add_option("--posture", arguments.posture,
                 "how much of a style's carriage of trunk, head and shoulders is kept while the "
                 "network shows none of the style, 0 to 1; for networks that run live")
      ->check(Number(0, 1))
      ->capture_default_str();
  app.add_flag("--no-bypass", arguments.no_bypass,
               "without a style, still go through bind, network and unbind");
  app.add_flag("--feet,!--no-feet", arguments.feet,
               "hold feet that the performer plants in place (default: --feet)");
  app.add_flag("--bind-only", arguments.bind_only,
               "only bind to the canonical humanoid and back, without the network");
}

void AddFileOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("-w,--weights", arguments.weights,
                 "weights: a file, or the name of shipped ones, like st-gcn (default: v2; open for "
                 "--like and --design)");
  app.add_option("--rig", arguments.rig, "rig dialect, e.g. bandai-namco, cmu")
      ->capture_default_str();
  app.add_option(
         "--rest", arguments.rest,
         "the upright pose from which the T-pose is derived if the clip's zero pose is not one: "
         "zero, "
         "the zero pose with its arms anywhere; standing, each limb from the frame in which it "
         "is straightest; the time of a frame in seconds; auto, the one that fits")
      ->check([](const std::string& text) { return clip::ParseRestPose(text).status().message(); })
      ->capture_default_str();
  app.add_option("--joints", arguments.joints,
                 "joints of the inputs whose names are not recognized, CANONICAL=NAME, e.g. "
                 "leftUpperArm=Arm_01")
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--like-joints", arguments.like_joints,
                 "the same for the clips of --like and --like-neutral")
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--up", arguments.up,
                 "the inputs' up axis, x, y, z, -x, -y or -z; auto: the zero pose's, or the one "
                 "along which the frames stand")
      ->check([](const std::string& text) { return clip::ParseUp(text).status().message(); })
      ->capture_default_str();
  app.add_option("--explain", arguments.explain,
                 "print how the skeleton of this clip or avatar is understood: its tree, each "
                 "joint's part, axes, unit and rest pose, and --joints to copy");
  CLI::Option* const avatar = app.add_option(
      "--avatar", arguments.avatar, "put the motion onto this skeleton: .vrm, .glb, .gltf or .bvh");
  app.add_option("--avatar-joints", arguments.avatar_joints,
                 "joints of the avatar whose names are not recognized, CANONICAL=NAME, e.g. "
                 "leftUpperArm=Arm_01; for a VRM they replace its own table of bones")
      ->take_all()
      ->allow_extra_args(false)
      ->needs(avatar);
  app.add_flag("--list", arguments.list, "print the styles of the weights");
  app.add_flag("--licence,--license", arguments.licence,
               "print the licences of the weights, and the names to credit");
  app.add_option(
      "files", arguments.files,
      "input clip (.bvh, .glb, .vrma) and output file (" + clip::FormatNames() +
          "), either of them - for the standard stream; with --out only inputs: files, folders of "
          "them, or -");
}

void AddOutputOptions(CLI::App& app, Arguments& arguments) {
  app.add_option(
      "-o,--out", arguments.out,
      "the outputs of all inputs and styles, e.g. 'out/{name}-{style}.bvh'; {dir} is "
      "the input's folder relative to the named one; - is the standard output. The extension "
      "decides the format: " +
          clip::FormatNames());
  std::vector<std::string> formats;
  for (const clip::Format& format : clip::Formats()) {
    formats.emplace_back(format.extension.substr(1));
  }
  app.add_option("--format", arguments.format, "the format of the standard output")
      ->check(CLI::IsMember(formats));
#ifdef STYLED_PREVIEW
  app.add_option("--preview", arguments.preview,
                 "also a picture of input and output, .png, or a video of both, .mp4 (needs "
                 "ffmpeg); a pattern as --out");
#endif
  app.add_option("--sheet", arguments.sheet,
                 "an .html file with all inputs in all styles: moving figures and numbers, for a "
                 "browser; without --out nothing else is written, and all files are inputs");
  app.add_flag("-r,--recursive", arguments.recursive, "folders with their subfolders");
  app.add_flag("--overwrite", arguments.overwrite, "replace outputs that exist; never an input");
  app.add_flag("--json", arguments.json, "a line of JSON for each output, instead of the summary");
  app.add_flag("-q,--quiet", arguments.quiet, "no summary and no progress");
}

// Options about styling or weights, which have no effect with --bind-only. Not CLI11's excludes(),
// which would list as many options behind each of them in the help.
constexpr const char* kNotWithBindOnly[] = {
    "--style",   "--strength", "--mix",     "--like",     "--like-neutral", "--design",
    "--vary",    "--amount",   "--window",  "--absolute", "--parts",        "--input-style",
    "--content", "--root",     "--cadence", "--neutral",  "--posture",      "--no-bypass",
    "--feet",    "--weights",  "--avatar"};

}  // namespace

void AddOptions(CLI::App& app, Arguments& arguments) {
  AddStyleOptions(app, arguments);
  AddStageOptions(app, arguments);
  AddFileOptions(app, arguments);
  AddOutputOptions(app, arguments);
}

std::string StyleWord(const Arguments& arguments) {
  const auto stem = [](const std::string& text) {
    return std::filesystem::path(text.substr(0, text.find('='))).stem().string();
  };
  std::string word = arguments.style.substr(0, arguments.style.find('='));
  const bool alone = word.empty();
  for (const std::string& text : arguments.mix) {
    if (alone) word += (word.empty() ? "" : "-") + text.substr(0, text.find('='));
  }
  for (const std::string& text : arguments.like) {
    if (alone) word += (word.empty() ? "" : "-") + stem(text);
  }
  return word.empty() ? "input" : word;
}

namespace {

Status CheckPreview(const Arguments& arguments) {
  if (arguments.preview.empty()) return Status::Ok();
  const std::string kind = std::filesystem::path(arguments.preview).extension();
  if (kind == ".png" || kind == ".mp4") return Status::Ok();
  return Status::Error("--preview " + arguments.preview + ": expected .png or .mp4");
}

// Decides which files are inputs and which outputs, as far as the command line alone allows.
Status CheckFiles(const Arguments& arguments) {
  const std::size_t count = arguments.files.size();
  const bool sheet_alone = !arguments.sheet.empty() && arguments.out.empty();
  if (!arguments.sheet.empty() && std::filesystem::path(arguments.sheet).extension() != ".html") {
    return Status::Error("--sheet " + arguments.sheet + ": expected a file .html");
  }
  if (sheet_alone && count > 0) return CheckPreview(arguments);
  if (count == 0 || (arguments.out.empty() && count == 1)) {
    return Status::Error(
        "expected an input and an output file, or, for a folder, --out and a pattern for all "
        "outputs, e.g. --out 'out/{name}-{style}.bvh'; see --help");
  }
  if (arguments.out.empty() && count > 2) {
    return Status::Error(
        "found " + std::to_string(count) +
        " files, expected an input and an output, or --out and a pattern for all outputs, e.g. "
        "--out 'out/{name}-{style}.bvh'");
  }
  const std::string& out = arguments.out.empty() ? arguments.files.back() : arguments.out;
  if (out != kStandard) {
    if (!arguments.format.empty()) {
      return Status::Error("--format " + arguments.format +
                           ": expected the standard output (-); a file's extension decides");
    }
    if (Status known = clip::FindFormat(out).status(); !known.ok()) return known;
  } else if (arguments.json) {
    return Status::Error("--json excludes the standard output, which has the clip");
  }
  if (std::count(arguments.files.begin(), arguments.files.end(), kStandard) >
      (arguments.out.empty() && out == kStandard ? 2 : 1)) {
    return Status::Error("-: found the standard input twice");
  }
  return CheckPreview(arguments);
}

}  // namespace

Status CheckTogether(const CLI::App& app, const Arguments& arguments) {
  if (!arguments.explain.empty() && !arguments.files.empty()) {
    return Status::Error("--explain: found other files, too, expected one clip or avatar alone");
  }
  if (arguments.list || arguments.licence || !arguments.explain.empty()) return Status::Ok();
  if (!arguments.like_joints.empty() && arguments.like.empty()) {
    return Status::Error("--like-joints: expected --like, whose clips they belong to");
  }
  if (Status files = CheckFiles(arguments); !files.ok()) return files;
  if (std::count(arguments.styles.begin(), arguments.styles.end(), "") > 0) {
    return Status::Error("--style: found nothing, expected a style; --list names them");
  }
  for (const char* const option : kNotWithBindOnly) {
    if (arguments.bind_only && app.count(option) > 0) {
      return Status::Error(std::string("--bind-only excludes ") + option);
    }
  }
  const bool without = arguments.styles.empty() && arguments.mix.empty() &&
                       arguments.like.empty() && arguments.design.empty();
  if (!arguments.input_style.empty() && without && !arguments.no_bypass) {
    return Status::Error(
        "--input-style: expected --style, --mix or --like, found none: give "
        "--style neutral to remove " +
        arguments.input_style);
  }
  if (!arguments.content.empty() && without && !arguments.no_bypass) {
    return Status::Error(
        "--content: expected a style, without which the network does not run: --style or --mix");
  }
  if (arguments.root != "follow" && without) {
    return Status::Error("--root stride: expected a style, whose speed it takes: --style or --mix");
  }
  if (arguments.cadence && without) {
    return Status::Error("--cadence: expected a style, whose steps it takes: --style or --mix");
  }
  return Status::Ok();
}

}  // namespace styled::stylize
