// stylize: restyles clips with the stylist that the daemon runs.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/base/terminal_text.h"
#include "model/clip/any_clip.h"
#include "model/clip/avatar.h"
#include "model/clip/avatar_write.h"
#include "model/clip/write.h"
#include "model/net/default_weights.h"
#include "model/net/load.h"
#include "model/net/shipped_weights.h"
#include "model/tools/command_line.h"
#include "model/tools/stylize/files.h"
#include "model/tools/stylize/licence.h"
#include "model/tools/stylize/preview.h"
#include "model/tools/stylize/report.h"
#include "model/tools/stylize/restyle.h"
#include "model/tools/stylize/sheet.h"
#include "model/tools/stylize/stylize.h"

namespace {

namespace stylize = styled::stylize;
using styled::Result;
using styled::Status;
using stylize::Arguments;
using stylize::Outcome;

constexpr int kSomeFailed = 3;  // written, but some frames are not styled

int Fail(const Status& status, int code = 1) {
  std::fprintf(stderr, "stylize: %s\n", styled::ForTerminal(status.message()).c_str());
  return code;
}

// Prints the styles of the weights, and on standard error which other weights there are.
int List(const Arguments& arguments) {
  auto network = stylize::LoadNetwork(arguments);
  if (!network.ok()) return Fail(network.status());
  std::printf("%s\n", stylize::StyleNames(network.value().model().styles).c_str());
  for (const std::string& content : network.value().model().contents) {
    std::fprintf(stderr, "content: --content %s\n", content.c_str());
  }
  const auto file = styled::stylize::FindWeightsFor(arguments);
  for (const auto& other : styled::net::OtherShippedWeights(file.value())) {
    std::fprintf(stderr, "other weights: --weights %s\n", other.stem().c_str());
  }
  return 0;
}

int Licence(const Arguments& arguments) {
  auto network = stylize::LoadNetwork(arguments);
  if (!network.ok()) return Fail(network.status());
  const auto file = styled::stylize::FindWeightsFor(arguments);
  std::printf("%s", stylize::LicenceText(file.value(), network.value().model()).c_str());
  return 0;
}

// Binds and unbinds every frame: shows what the canonical humanoid alone does to a clip.
void BindOnly(const styled::rig::Binding& binding, styled::clip::Clip& clip) {
  styled::body::Pose pose;
  styled::rig::RigPose out(clip.skeleton);
  for (styled::rig::RigPose& frame : clip.frames) {
    binding.Bind(frame, pose);
    binding.Unbind(pose, frame, out);
    std::swap(frame, out);
  }
}

// One output: an input in a style.
struct Job {
  const stylize::Input* input;
  std::size_t style;  // index of the run's styles
  std::string out, preview;
};

// A clip as it is read, with its binding.
struct Source {
  styled::clip::Clip clip;
  bool is_gltf;  // in metres
  std::shared_ptr<const styled::rig::Binding> binding;
  std::string dialect, rest;
};

class Run {
 public:
  explicit Run(const Arguments& arguments) : arguments_(arguments), guard_(arguments.overwrite) {}

  int All() {
    if (const Status planned = Plan(); !planned.ok()) return Fail(planned, styled::kBadArguments);
    if (const Status asked = CheckArguments(); !asked.ok())
      return Fail(asked, styled::kBadArguments);
    if (const Status prepared = ReadFiles(); !prepared.ok()) return Fail(prepared);
    if (const Status made = MakeRestylers(); !made.ok()) return Fail(made, styled::kBadArguments);
    stylize::ProgressLine progress(!arguments_.quiet, jobs_.size());
    progress_ = &progress;
    std::size_t written = 0;
    bool some_own = false, failed = broken_ > 0;
    for (const stylize::Input& input : inputs_) {
      if (input.error.empty()) continue;
      Outcome outcome;
      outcome.in = input.file;
      outcome.error = input.error;
      Tell(outcome);
    }
    for (const Job& job : jobs_) {
      const Outcome outcome = Do(job);
      Tell(outcome);
      if (!arguments_.sheet.empty()) sheet_.Add(outcome, shown_input_, shown_output_);
      if (outcome.written) ++written;
      failed |= !outcome.error.empty();
      some_own |= outcome.own > 0;
    }
    if (!arguments_.sheet.empty()) failed |= !WriteSheet();
    progress_ = nullptr;
    const std::size_t wanted = jobs_.size() + broken_;
    if (wanted > 1 && written < wanted) {
      progress.Clear();
      std::fprintf(stderr, "stylize: %zu of %zu outputs are written\n", written, wanted);
    }
    if (failed) return 1;
    return some_own ? kSomeFailed : 0;
  }

 private:
  // Plans the outputs. No file is read yet.
  Status Plan() {
    std::vector<std::string> named = arguments_.files;
    std::string out = arguments_.out;
    if (out.empty() && arguments_.sheet.empty()) {
      out = named.back();
      named.pop_back();
    }
    inputs_ = stylize::FindInputs(named, arguments_.recursive);
    styles_ = arguments_.styles;
    for (std::size_t i = 0; i < styles_.size(); ++i) {
      const auto name = [this](std::size_t at) {
        return styles_[at].substr(0, styles_[at].find('='));
      };
      for (std::size_t k = 0; k < i; ++k) {
        if (name(k) == name(i)) {
          return Status::Error("--style: " + name(i) + " is named twice, expected each style once");
        }
      }
    }
    if (styles_.empty()) styles_.emplace_back();
    std::map<std::string, std::string> outputs;  // and whose they are
    for (const stylize::Input& input : inputs_) {
      if (!input.error.empty()) {
        ++broken_;
        continue;
      }
      for (std::size_t style = 0; style < styles_.size(); ++style) {
        Arguments one = arguments_;
        one.style = styles_[style];
        const stylize::Words words{input.name, input.dir, stylize::StyleWord(one)};
        Job job{&input, style, "", ""};
        for (const auto& [pattern, filled] :
             {std::pair<const std::string*, std::string*>{&out, &job.out},
              {&arguments_.preview, &job.preview}}) {
          if (pattern->empty()) continue;
          auto text = stylize::FillPattern(*pattern, words);
          if (!text.ok()) return text.status();
          const std::string same = std::filesystem::path(text.value()).lexically_normal().string();
          *filled = same;
          const std::string whose = input.file + (one.style.empty() ? "" : " (" + one.style + ")");
          const auto [other, fresh] = outputs.emplace(same, whose);
          if (fresh) continue;
          return Status::Error(text.value() + ": found twice, for " + other->second + " and " +
                               whose +
                               ", expected an output for each; {name}, {dir} and {style} in the "
                               "output's name tell them apart, e.g. --out "
                               "'out/{dir}/{name}-{style}.bvh'");
        }
        jobs_.push_back(std::move(job));
      }
    }
    to_stdout_ = out == stylize::kStandard;
    return Status::Ok();
  }

  // Checks that need only the command line.
  Status CheckArguments() {
    auto joints = styled::rig::ParseJoints("--joints", arguments_.joints);
    if (!joints.ok()) return joints.status();
    joints_ = std::move(joints.value());
    auto avatar_joints = styled::rig::ParseJoints("--avatar-joints", arguments_.avatar_joints);
    if (!avatar_joints.ok()) return avatar_joints.status();
    avatar_joints_ = std::move(avatar_joints.value());
    return stylize::CheckExampleWeights(arguments_);
  }

  // Reads what all outputs need, each file once: avatar, weights, examples.
  Status ReadFiles() {
    for (const stylize::Input& input : inputs_) guard_.Reads(input.file, "the input");
    if (!arguments_.sheet.empty()) {
      if (Status free = guard_.Check(arguments_.sheet); !free.ok()) return free;
    }
    if (!arguments_.avatar.empty()) {
      auto read = styled::clip::ReadAvatar(arguments_.avatar, "auto", avatar_joints_);
      if (!read.ok()) {
        return Status::Error("--avatar " + read.status().message() +
                             " (joints by hand: --avatar-joints)");
      }
      avatar_ = std::move(read.value());
      guard_.Reads(arguments_.avatar, "the avatar");
      auto meshes = styled::clip::AvatarFile::Read(arguments_.avatar, *avatar_);
      if (meshes.ok()) {
        meshes_ = std::move(meshes.value());
      } else {
        why_not_kept_ = meshes.status().message();
      }
    }
#ifdef STYLED_PREVIEW
    if (Status can = stylize::CanPreview(arguments_.preview); !can.ok()) return can;
#endif
    for (const std::string& text : arguments_.like) {
      guard_.Reads(text, "the example");
      guard_.Reads(text.substr(0, text.rfind('=')), "the example");
    }
    guard_.Reads(arguments_.like_neutral, "the clip of --like-neutral");
    guard_.Reads(arguments_.neutral, "the clip of --neutral");
    if (arguments_.bind_only) return Status::Ok();
    auto network = stylize::LoadNetwork(arguments_);
    if (!network.ok()) return network.status();
    if (const auto weights = styled::stylize::FindWeightsFor(arguments_); weights.ok()) {
      guard_.Reads(weights.value(), "the weights");
    }
    network_ = std::move(network.value());
    auto examples = stylize::ReadExamples(arguments_, network_.model(), stylize::SpaceOf(network_));
    if (!examples.ok()) return examples.status();
    examples_ = std::move(examples.value());
    auto neutral = stylize::ReadNeutral(arguments_, joints_, network_.model());
    if (!neutral.ok()) return neutral.status();
    neutral_ = std::move(neutral.value());
    return Status::Ok();
  }

  // Applies the command line to these weights, for each style.
  Status MakeRestylers() {
    if (arguments_.bind_only) return Status::Ok();
    for (const std::string& style : styles_) {
      Arguments one = arguments_;
      one.style = style;
      auto restyler = stylize::Restyler::Make(one, examples_, neutral_, network_);
      if (!restyler.ok()) return restyler.status();
      restylers_.push_back(std::move(restyler.value()));
    }
    if (!examples_.styled.empty() && !arguments_.quiet) {
      stylize::PrintNearest(examples_, network_.model().styles, *stylize::SpaceOf(network_));
    }
    return Status::Ok();
  }

  Result<Source> Read(const stylize::Input& input) const {
    const bool standard = input.file == stylize::kStandard;
    std::string text;
    if (standard) {
      auto read = stylize::ReadStandardInput();
      if (!read.ok()) return read.status();
      text = std::move(read.value());
    }
    const std::string name = standard ? "standard input" : input.file;
    auto clip = standard ? styled::clip::ParseAnyClip(text, name, {}, joints_)
                         : styled::clip::ReadAnyClip(input.file, {}, joints_);
    if (!clip.ok()) return clip.status();
    stylize::Warn(name, clip.value().clip.remark);
    auto bound = styled::clip::BindAnyClip(
        clip.value(), {arguments_.rig, styled::clip::ParseRestPose(arguments_.rest).value(),
                       joints_, styled::clip::ParseUp(arguments_.up).value()});
    if (!bound.ok()) {
      const std::string& why = bound.status().message();
      const bool joints =
          why.find("joint") != std::string::npos && why.find("found no pose") == std::string::npos;
      return Status::Error(name + ": " + why +
                           (joints ? " (by hand: --joints CANONICAL=NAME; --explain prints them)"
                                   : " (by hand: --rest, --up; --explain shows the skeleton)"));
    }
    stylize::Warn(name, bound.value().remark);
    return Source{std::move(clip.value().clip), clip.value().is_gltf,
                  std::make_shared<const styled::rig::Binding>(std::move(bound.value().binding)),
                  bound.value().dialect, bound.value().rest};
  }

  // The job's input, read once for all of its styles.
  const Result<Source>& SourceOf(const Job& job) {
    if (source_of_ != job.input) {
      source_.emplace(Read(*job.input));
      source_of_ = job.input;
    }
    return *source_;
  }

  Outcome Do(const Job& job) {
    Outcome outcome;
    outcome.in = job.input->file;
    outcome.out = job.out.empty() ? arguments_.sheet : job.out;
    outcome.style = styles_[job.style];
    progress_->Next(job.input->name + " " + outcome.style);
    for (const std::string* const file : {&job.out, &job.preview}) {
      if (file->empty() || *file == stylize::kStandard) continue;
      if (const Status free = guard_.Check(*file); !free.ok()) {
        outcome.error = free.message();
        return outcome;
      }
    }
    const auto& source = SourceOf(job);
    if (!source.ok()) {
      outcome.error = source.status().message();
      return outcome;
    }
    const Status done = Make(job, source.value(), outcome);
    if (!done.ok()) outcome.error = done.message();
    return outcome;
  }

  Status Make(const Job& job, const Source& source, Outcome& outcome) {
    styled::clip::Clip clip = source.clip;
    outcome.frames = outcome.input_frames = clip.frames.size();
    outcome.rate_hz = clip.rate_hz;
    outcome.dialect = source.dialect;
    outcome.rest = source.rest;
    stylize::Styled styled;
    if (arguments_.bind_only) {
      BindOnly(*source.binding, clip);
    } else {
      auto result = restylers_[job.style].Run(
          job.input->file, source.binding, avatar_ ? &*avatar_ : nullptr,
          [this](double share) { progress_->Show(share); }, clip);
      if (!result.ok()) return result.status();
      styled = std::move(result.value());
      outcome.styled = true;
      outcome.own = styled.failed;
      outcome.planted = styled.planted;
      outcome.out_of_domain = styled.out_of_domain;
      outcome.slide_cm_s = styled.slide_cm_s;
      outcome.input_slide_cm_s = styled.input_slide_cm_s;
      outcome.can_stride = styled.can_stride;
      outcome.turned_deg = styled.turned_deg;
      outcome.moved_cm = styled.moved_cm;
      outcome.seconds = styled.seconds;
      outcome.unseen_s = styled.unseen_s;
      outcome.shown = styled.shown;
    }
    if (avatar_) {
      clip.skeleton = avatar_->binding->skeleton();
      clip.channels.clear();
      clip.end_sites.clear();
    }
    if (arguments_.cadence) {
      progress_->Clear();
      stylize::Retime(outcome.out, styled.times_s, !arguments_.quiet, clip);
      outcome.frames = clip.frames.size();
    }
    return Write(job, source, std::move(clip), outcome);
  }

  Status Write(const Job& job, const Source& source, styled::clip::Clip clip, Outcome& outcome) {
    const auto& binding = avatar_ ? avatar_->binding : source.binding;
    const auto& written_on = *binding;
    styled::clip::Motion motion;
    static_cast<styled::clip::Clip&>(motion) = std::move(clip);
    motion.name = job.input->name;
    if (!outcome.style.empty()) motion.name += " " + outcome.style;
    motion.binding = binding;
    motion.rest = written_on.spec().rest_rotations;
    motion.canonical_from_source = written_on.spec().canonical_from_source;
    // A BVH does not state its unit: scale the body to the humanoid's height.
    const bool in_metres = avatar_ ? avatar_->metres_per_unit > 0 : source.is_gltf;
    motion.metres_per_unit = in_metres ? 1 : written_on.scale();
    if (!job.out.empty()) {
      if (Status written = WriteClip(job, motion, written_on, in_metres, outcome); !written.ok()) {
        return written;
      }
    }
    outcome.written = true;
    if (!arguments_.sheet.empty()) {
      shown_input_ = {styled::clip::ToCanonical(source.clip, *source.binding), source.clip.rate_hz};
      shown_output_ = {styled::clip::ToCanonical(motion, written_on), motion.rate_hz};
    }
    return Preview(job, source, written_on, motion, outcome);
  }

  Status WriteClip(const Job& job, const styled::clip::Motion& motion,
                   const styled::rig::Binding& written_on, bool in_metres, Outcome& outcome) {
    const bool standard = job.out == stylize::kStandard;
    const std::string format = arguments_.format.empty() ? "bvh" : arguments_.format;
    const std::string kind =
        standard ? "." + format : std::string(styled::clip::FindFormat(job.out).value()->extension);
    const bool keep = meshes_ && kind == ".glb";
    if (avatar_ && kind == ".glb" && !keep) {
      outcome.note = "bones alone, without meshes: " + why_not_kept_;
    }
    const auto write = [&](const std::string& file) {
      if (keep) return meshes_->Write(*avatar_, motion, file);
      if (kind != ".bvh" || !in_metres) return styled::clip::Write(file, motion);
      return styled::clip::WriteBvh(styled::clip::AsBvh(motion, written_on), file);
    };
    return standard ? stylize::WriteToStandardOutput(kind, write) : guard_.Write(job.out, write);
  }

  // Whether the sheet of all outputs is written.
  bool WriteSheet() {
    progress_->Clear();
    if (sheet_.outputs() == 0) {
      Fail(Status::Error(arguments_.sheet + ": is not written: found no output to show"));
      return false;
    }
    const Status written = guard_.Write(
        arguments_.sheet, [this](const std::string& file) { return sheet_.Write(file); });
    if (!written.ok()) {
      Fail(written);
    } else if (!arguments_.quiet && !arguments_.json) {
      std::error_code error;
      const double bytes = static_cast<double>(std::filesystem::file_size(arguments_.sheet, error));
      std::fprintf(to_stdout_ ? stderr : stdout, "%s: moving figures: %zu, %.0f kB\n",
                   styled::ForTerminal(arguments_.sheet).c_str(), sheet_.outputs(), bytes / 1000);
    }
    return written.ok();
  }

  Status Preview(const Job& job, const Source& source, const styled::rig::Binding& written_on,
                 const styled::clip::Clip& clip, Outcome& outcome) {
    if (job.preview.empty()) return Status::Ok();
#ifdef STYLED_PREVIEW
    stylize::Shown shown{styled::clip::ToCanonical(source.clip, *source.binding),
                         styled::clip::ToCanonical(clip, written_on), clip.rate_hz,
                         outcome.style.empty() ? "output" : outcome.style};
    Status made = guard_.Write(job.preview, [&shown](const std::string& file) {
      return stylize::WritePreview(shown, file);
    });
    if (made.ok()) outcome.preview = job.preview;
    return made;
#else
    return Status::Error("--preview: found a build without pictures");
#endif
  }

  // Reports the result of an output.
  void Tell(const Outcome& outcome) {
    progress_->Clear();
    if (!outcome.error.empty()) {
      std::fprintf(stderr, "stylize: %s\n", styled::ForTerminal(outcome.error).c_str());
    } else if (outcome.own > 0) {
      std::fprintf(stderr,
                   "stylize: %s: %zu of %zu frames are the performer's own: expected a finite pose "
                   "with unit rotations from the network, found none\n",
                   outcome.out.c_str(), outcome.own, outcome.input_frames);
    }
    if (outcome.error.empty()) stylize::Warn(outcome.out, stylize::SlideWarning(outcome));
    if (arguments_.json) {
      std::printf("%s\n", stylize::JsonLine(outcome).c_str());
    } else if (outcome.error.empty() && !arguments_.quiet) {
      std::fprintf(to_stdout_ ? stderr : stdout, "%s\n",
                   styled::ForTerminal(stylize::SummaryLine(outcome)).c_str());
    }
    std::fflush(stdout);
  }

  const Arguments& arguments_;
  stylize::Guard guard_;
  std::vector<stylize::Input> inputs_;
  std::vector<std::string> styles_;  // "" where none is named
  std::vector<Job> jobs_;
  std::size_t broken_ = 0;  // inputs with an error
  bool to_stdout_ = false;
  styled::rig::JointNames joints_, avatar_joints_;
  std::optional<styled::clip::AvatarSkeleton> avatar_;
  std::optional<styled::clip::AvatarFile> meshes_;
  std::string why_not_kept_;  // why the avatar's meshes are not in a .glb; "": they are
  styled::net::AnyStylizer network_;
  stylize::Examples examples_;
  std::optional<styled::neutral::Known> neutral_;  // of a file
  std::vector<stylize::Restyler> restylers_;       // per style
  const stylize::Input* source_of_ = nullptr;
  std::optional<Result<Source>> source_;
  stylize::ProgressLine* progress_ = nullptr;
  stylize::Sheet sheet_;
  stylize::SheetMotion shown_input_, shown_output_;  // of the last output
};

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "Restyles clips (BVH, glTF, VRMA), on their own skeletons or on an avatar's: same rate and, "
      "except for "
      "--cadence, same frame count.",
      "stylize");
  stylize::AddOptions(app, arguments);
  if (const auto ended = styled::Parse(app, argc, argv, styled::net::DescribeDefaultWeights))
    return *ended;
  const Status together = stylize::CheckTogether(app, arguments);
  if (!together.ok()) return Fail(together, styled::kBadArguments);
  if (!arguments.explain.empty()) {
    const Status explained = stylize::Explain(arguments);
    return explained.ok() ? 0 : Fail(explained);
  }
  if (arguments.licence) return Licence(arguments);
  return arguments.list ? List(arguments) : Run(arguments).All();
}
