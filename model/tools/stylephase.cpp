// Measures a weights file of the family "phase" from clips: the neutral of many people and a table
// per style, by gait phase. Nothing is trained; a minute of motion takes some milliseconds.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "model/base/write_file.h"
#include "model/clip/entry_reader.h"
#include "model/net/phase/design.h"
#include "model/net/phase/stylizer.h"
#include "model/tools/command_line.h"

namespace styled {
namespace {

constexpr float kRate_hz = 30;  // of the file, and of the clips' analysis

struct Arguments {
  std::string manifest, data, out, split, library, prefix;
  bool clips = false, designs = false;
};

// The analyses of one style's clips.
struct StyleClips {
  std::vector<phase::Weighted> clips;
};

std::vector<body::Pose> Mirrored(std::vector<body::Pose> poses) {
  for (body::Pose& pose : poses) body::Mirror(pose, pose);
  return poses;
}

// A long clip counts no more than one of so many seconds, so that no person decides alone.
constexpr float kCounted_s = 20;

std::string GaitText(const std::optional<gait::Gait>& gait) {
  if (!gait) return "        -                 ";
  char text[80];
  std::snprintf(text, sizeof text, "%6.1f s %4.2f Hz %4.2f m/s %4.2f", double(gait->seconds),
                double(gait->rate_rad_s / gait::tuning::kTurn_rad), double(gait->speed_mps),
                double(gait->explained));
  return text;
}

void Add(const std::string& name, std::span<const body::Pose> poses, bool print, StyleClips& to) {
  const gait::Analysis analysis = gait::Analyse(poses, kRate_hz);
  if (print) {
    std::printf("  %-34s %-36s %-36s %4.1f of %5.1f s\n", name.c_str(),
                GaitText(analysis.walk).c_str(), GaitText(analysis.run).c_str(),
                double(analysis.standing_s), double(analysis.seconds));
  }
  to.clips.push_back({phase::StyleOf(analysis), std::min(analysis.seconds, kCounted_s)});
}

neutral::Reference ReferenceOf(const phase::Style& neutral) {
  neutral::Reference reference;
  reference.walking.rotations = neutral.walk->curve.mean;
  reference.running.rotations = neutral.run->curve.mean;
  reference.standing.rotations = neutral.standing.value_or(neutral.walk->curve.mean);
  return reference;
}

// Of the neutral, to which those of styles are compared: most people's speeds, since a few actors
// may be slow ones, and the clips' cadences.
void SetSpeeds(const phase::Style& neutral, net::StyleInfo& info) {
  info.walk_mps = neutral::Reference().walk_mps;
  info.run_mps = neutral::Reference().run_mps;
  const auto steps = [](const gait::Gait& gait) {
    return 2 * 60 * gait.rate_rad_s / gait::tuning::kTurn_rad;
  };
  info.walk_spm = steps(*neutral.walk);
  info.run_spm = steps(*neutral.run);
}

// The designs that a user may begin with, as styles.
void AddDesigns(net::Model& model, std::vector<net::StyleCode>& codes) {
  phase::Style nobody;
  nobody.difference = true;
  nobody.walk.emplace();
  nobody.standing = nobody.posture;
  for (const net::Preset& preset : phase::Presets()) {
    codes.push_back(phase::ToCode(phase::WithSliders(nobody, preset.values).value()));
    net::StyleInfo& info = model.styles.emplace_back();
    info.name = preset.name;
    info.licence = "that of this program";
    info.credit = "designed by hand";
    std::printf("%-16s by hand\n", preset.name);
  }
}

// A file NAME.json per style, as the daemon's library has them and `stylectl styles import` reads
// them.
Status WriteLibrary(const Arguments& arguments, const net::Model& model,
                    const std::vector<net::StyleCode>& codes) {
  std::error_code error;
  std::filesystem::create_directories(arguments.library, error);
  for (std::size_t s = 0; s < codes.size(); ++s) {
    const net::StyleInfo& style = model.styles[s];
    const std::string name = arguments.prefix + style.name;
    const phase::Style measured = phase::FromCode(codes[s]);
    const nlohmann::ordered_json file{
        {"format", "styled style 1"},
        {"name", name},
        {"weights", ""},
        {"licence", style.licence.empty() ? model.licence : style.licence},
        {"source", style.credit.empty() ? model.licence : style.credit},
        {"seconds", measured.seconds},
        {"code", codes[s]}};
    const std::filesystem::path path = std::filesystem::path(arguments.library) / (name + ".json");
    if (Status status = WriteFileAtomically(path.string(), file.dump() + "\n"); !status.ok())
      return status;
  }
  std::printf("%zu styles in %s\n", codes.size(), arguments.library.c_str());
  return Status::Ok();
}

Status Run(const Arguments& arguments) {
  const auto manifest = clip::LoadManifest(arguments.manifest, arguments.data);
  if (!manifest.ok()) return manifest.status();
  const auto& styles = manifest.value().styles;
  std::vector<StyleClips> clips(styles.size());
  clip::EntryReader reader;
  for (const clip::ManifestEntry& entry : manifest.value().entries) {
    if (!arguments.split.empty() && entry.split != arguments.split) continue;
    const auto poses = reader.Read(entry, static_cast<double>(kRate_hz));
    if (!poses.ok()) return poses.status();
    if (poses.value().size() < 2) continue;
    const auto style = static_cast<std::size_t>(
        std::find_if(styles.begin(), styles.end(),
                     [&](const auto& one) { return one.name == entry.style; }) -
        styles.begin());
    const std::string name = entry.file.filename().string();
    Add(name, poses.value(), arguments.clips, clips[style]);
    if (style == 0) Add(name, Mirrored(poses.value()), false, clips[style]);
  }
  net::Model model;
  model.rate_hz = kRate_hz;
  model.licence = manifest.value().licence;
  model.training = nlohmann::json{{"command", "stylephase --designs --split " + arguments.split},
                                  {"data", manifest.value().name}}
                       .dump();
  std::vector<net::StyleCode> codes;
  std::printf("%-16s %-36s %-36s %s\n", "", "walk: cadence, speed, explained", "run", "stands");
  for (std::size_t s = 0; s < styles.size(); ++s) {
    if (clips[s].clips.empty()) {
      return Status::Error(arguments.manifest + ": no clip of \"" + styles[s].name + "\"");
    }
    const phase::Style style = phase::MeanOf(clips[s].clips);
    const bool is_neutral = s == 0 && arguments.library.empty();
    if (is_neutral && (!style.walk || !style.run)) {
      return Status::Error(arguments.manifest + ": neutral: found " +
                           (style.walk ? "no run" : "no walk") + ", expected both");
    }
    if (is_neutral) model.reference = ReferenceOf(style);
    std::printf("%-16s %-36s %-36s %s\n", styles[s].name.c_str(), GaitText(style.walk).c_str(),
                GaitText(style.run).c_str(), style.standing ? "yes" : "-");
    net::StyleInfo& info = model.styles.emplace_back();
    info.name = styles[s].name;
    info.aliases = styles[s].aliases;
    if (is_neutral) SetSpeeds(style, info);
    info.licence = styles[s].licence;
    info.credit = styles[s].credit;
    codes.push_back(phase::ToCode(style));
  }
  if (!arguments.library.empty()) return WriteLibrary(arguments, model, codes);
  if (arguments.designs) AddDesigns(model, codes);
  return phase::Write(arguments.out, model, codes);
}

}  // namespace
}  // namespace styled

int main(int argc, char** argv) {
  styled::Arguments arguments;
  CLI::App app("Measures a weights file of the family \"phase\" from the clips of a manifest.");
  app.add_option("--manifest", arguments.manifest, "Data set (TOML)")->required();
  app.add_option("--data", arguments.data, "Folder that the manifest's paths start from")
      ->required();
  app.add_option("--split", arguments.split, "Only clips of this split; else all");
  app.add_flag("--designs", arguments.designs, "Add the styles that are designed by hand");
  app.add_flag("--clips", arguments.clips, "Print what each clip shows");
  CLI::Option* const out = app.add_option("--out", arguments.out, "The weights file");
  CLI::Option* const library = app.add_option(
      "--library", arguments.library,
      "Instead of a weights file: a folder for a file per style, as [style] library of "
      "the daemon");
  out->excludes(library);
  app.add_option("--prefix", arguments.prefix, "Before each style's name in the library")
      ->needs(library);
  if (const auto ended = styled::Parse(app, argc, argv)) return *ended;
  if (arguments.out.empty() && arguments.library.empty()) {
    std::cerr << "stylephase: expected --out or --library\n";
    return styled::kBadArguments;
  }
  const styled::Status status = styled::Run(arguments);
  if (status.ok()) return 0;
  std::cerr << "stylephase: " << status.message() << "\n";
  return 1;
}
