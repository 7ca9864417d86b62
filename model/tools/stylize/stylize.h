#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/body/parts.h"
#include "model/body/pose.h"
#include "model/clip/clip.h"
#include "model/net/clip_stylizer.h"
#include "model/net/styles.h"
#include "model/neutral/neutral.h"
#include "model/rig/dialects.h"
#include "model/stylist/clip_stylist.h"
#include "model/stylist/settings.h"

// Declarations that the sources of the program stylize share.
namespace styled::stylize {

struct Arguments {
  std::vector<std::string> styles;  // each is applied by itself
  std::string style;                // the one of these that is due; "": none
  float strength = 1.0F;
  std::vector<std::string> mix;
  std::vector<std::string> like;      // clips that are examples of the style
  std::string like_neutral;           // a clip of the examples' performer without the style
  std::string design;                 // a design's name, or SLIDER=NUMBER,...
  std::optional<std::uint64_t> vary;  // seed of the variation of every style named
  float amount = 1.0F;                // of that variation
  float posture = 1.0F;               // stylist::Options::posture
  std::string window = "auto";        // a row of kWindows
  std::string parts = "all";          // parts of the body to style
  std::string root = "follow";        // or "stride": stylist::Root
  std::string neutral = "clip";       // or "live", "none", or a clip of the performer
  std::string input_style;            // the style that the performer moves in
  std::string content;                // of the motion; "": the network recognizes it
  bool cadence = false;               // warp time, so that steps come as often as the style's
  bool absolute = false, no_bypass = false, feet = true, bind_only = false, list = false;
  bool licence = false;
  std::string weights, rig = "auto", rest = "auto", avatar;
  std::vector<std::string> files;  // inputs; without `out` an input and an output
  std::string out;                 // pattern, or kStandard
  std::string format;              // of standard output: an extension without its dot
  std::string preview;             // pattern
  std::string sheet;               // an .html file
  bool recursive = false, overwrite = false, json = false, quiet = false;
  std::vector<std::string> joints, avatar_joints, like_joints;  // CANONICAL=NAME
  std::string up = "auto";                                      // clip::ParseUp
  std::string explain;                                          // a clip or an avatar
};

struct Window {
  const char* word;
  net::Extent extent;
};
inline constexpr Window kWindows[] = {{"auto", net::Extent::kByLength},
                                      {"whole", net::Extent::kWhole},
                                      {"overlapping", net::Extent::kWindows}};

// options.cpp: fills `arguments` as `app` parses.
void AddOptions(CLI::App& app, Arguments& arguments);
// Checks that the parser does not make: arguments that are missing or have no effect alone.
Status CheckTogether(const CLI::App& app, const Arguments& arguments);

// explain.cpp: prints how the skeleton of arguments.explain is understood. Errors: those of reading
// and binding it; its tree is printed nevertheless.
Status Explain(const Arguments& arguments);

// "a, b, c"
std::string StyleNames(const net::Styles& styles);
// Parses the A of "S=A", a number from 0 to net::kMaxStrength; `option` and `text`, the whole
// argument, are for errors.
Result<float> ParseWeight(const std::string& number, const char* option, const std::string& text);
// Parses "S=A" or "S"; errors name the option.
struct Weighted {
  int style = 0;
  std::optional<float> weight;
};
Result<Weighted> FindWeighted(const net::Styles& styles, const std::string& text,
                              const char* option);
// The arguments that have weights: "--style old, --like a.bvh=0.9, --strength 1.2"
std::string WeightsText(const Arguments& arguments);
// The error for weights that sum to more than they may, times the strength.
Status TooMuch(const Arguments& arguments, float sum);
// The performer's own style, 0 if the arguments name none.
Result<int> FindInputStyle(const Arguments& arguments, const net::Styles& styles);
// The content that --content names: its number, or kContentRecognized without the option.
Result<int> FindInputContent(const Arguments& arguments, const net::Model& model);
Result<body::Parts> FindParts(const Arguments& arguments);
const char* Explain(stylist::SettingsError error);

// The output's name, or the text for {style} in it: the style's, otherwise those that it is made
// of.
std::string StyleWord(const Arguments& arguments);

// gait.cpp: whether the weights know what --root stride and --cadence need, of neutral and
// of each style that `settings` names; the error names the option and the style.
Status CheckGait(const Arguments& arguments, const net::Styles& styles,
                 const stylist::Settings& settings);
// Puts the frames of a styled clip at `times_s` (clip::Retime), and prints both lengths on standard
// error; `file` is the output's name.
void Retime(const std::string& file, std::span<const double> times_s, bool say, clip::Clip& clip);

// neutral.cpp: the words of --neutral; anything else is a file.
inline constexpr const char* kNeutralOfClip = "clip";
inline constexpr const char* kNeutralLive = "live";
inline constexpr const char* kNoNeutral = "none";
// The neutral from the clip that --neutral names; empty if it names none. A clip in which no
// performer stands or walks is an error; errors name the file.
Result<std::optional<neutral::Known>> ReadNeutral(const Arguments& arguments,
                                                  const rig::JointNames& joints,
                                                  const net::Model& model);

// An example of a style, as --like names it.
struct Example {
  std::string file;
  std::optional<float> weight;
  std::vector<body::Pose> poses;  // at the network's rate
};
struct Examples {
  std::vector<Example> styled;
  std::vector<body::Pose> neutral;  // of --like-neutral
};
// The weights file that the arguments name, or that suits them.
Result<std::filesystem::path> FindWeightsFor(const Arguments& arguments);
// Reads the examples that --like names; empty for a network without a space of styles. Errors name
// the file. Invalid weights are refused by CheckExampleWeights.
Result<Examples> ReadExamples(const Arguments& arguments, const net::Model& model,
                              const net::StyleSpace* space);
Status CheckExampleWeights(const Arguments& arguments);
// Prints on standard error how far each is from the styles that the network knows.
void PrintNearest(const Examples& examples, const net::Styles& styles,
                  const net::StyleSpace& space);

// The request that the arguments make to a network that needs whole clips.
Result<stylist::ClipStyle> ParseClipStyle(const Arguments& arguments, const Examples& examples,
                                          const net::ClipStylizer& network);
// The combination of --style, --mix, --like and --vary, and its total weight.
struct Blend {
  net::StyleCode code;
  float weight = 1;
  float strength = 1;  // to be applied; 1: the code has it
};
Result<Blend> MakeBlend(const Arguments& arguments, const Examples& examples,
                        const net::Model& model, const net::StyleSpace& space, int input_style);
// Whether a clip has the frames that the network needs; the error names its file.
Status CheckLength(const clip::Clip& clip, const std::string& file, const net::Model& model,
                   const net::StyleSpace& space);
// The first argument that this network of live streams cannot serve.
Status RefuseClipArguments(const Arguments& arguments, const net::Stylizer& network);

}  // namespace styled::stylize
