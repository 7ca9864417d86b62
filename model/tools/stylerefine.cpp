// stylerefine: fits a style of a library to its takes, by gradient, and writes a better style file.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>

#include "model/base/crc32c.h"
#include "model/clip/clip.h"
#include "model/net/default_weights.h"
#include "model/net/shipped_weights.h"
#include "model/net/weights_file.h"
#include "model/rig/dialects.h"
#include "model/synthetic/performer.h"
#include "model/tools/command_line.h"
#include "model/tools/number.h"
#include "model/train/blas.h"
#include "model/train/stgcn_causal/refiner.h"
#include "model/train/stgcn_causal/style_file.h"

namespace styled::train::st_gcn_causal {
namespace {

using Poses = std::vector<body::Pose>;
using Clock = std::chrono::steady_clock;

constexpr int kNice = 10;
constexpr double kJudgedShare = 0.25;  // of each take, its end
constexpr double kLeast_s = 2;         // of all takes together
constexpr double kReport_s = 3;        // between two lines
// A take is asymmetric on purpose if the difference of its mean pose from the mirror image exceeds
// this share of its difference from the neutral one, and these centimetres.
constexpr double kAsymmetry = 0.5, kAsymmetry_cm = 1.5;
// The maximum speeds of a performer who stands, and who walks.
constexpr double kStanding_m_s = 0.25, kWalking_m_s = 2.2;
constexpr int kPerformers = 6;  // built-in ones, the last two for the figures
constexpr double kPerformance_s = 24;

std::atomic<bool> interrupted{false};

struct Arguments {
  std::string style, weights, out;
  std::vector<std::string> clips, neutral;
  double minutes = 1;
  int64_t iterations = 0;
  bool anew = false;
  std::string mirror = "auto";
  RefineConfig config;
};

// The canonical poses of a clip of any rig, at the network's rate.
Result<Poses> ReadPoses(const std::filesystem::path& file, double rate_hz) {
  const Result<clip::Clip> clip = clip::ReadBvh(file);
  if (!clip.ok()) return clip.status();
  const Result<rig::Binding> binding = rig::BindDialect(clip.value().skeleton);
  if (!binding.ok()) return Status::Error(file.string() + ": " + binding.status().message());
  return clip::ResamplePoses(clip::ToCanonical(clip.value(), binding.value()), clip.value().rate_hz,
                             rate_hz);
}

Result<std::vector<Poses>> ReadAll(const std::vector<std::string>& files, double rate_hz) {
  std::vector<Poses> all;
  for (const std::string& file : files) {
    Result<Poses> poses = ReadPoses(file, rate_hz);
    if (!poses.ok()) return poses.status();
    if (poses.value().size() < 2) return Status::Error(file + ": expected at least two frames");
    all.push_back(std::move(poses.value()));
  }
  return all;
}

// The take beside the style's file, if there is one, and those of --clip.
Result<std::vector<std::string>> TakesOf(const Arguments& arguments) {
  std::vector<std::string> files;
  const std::filesystem::path beside =
      std::filesystem::path(arguments.style).replace_extension(".bvh");
  if (std::filesystem::exists(beside)) files.push_back(beside.string());
  files.insert(files.end(), arguments.clips.begin(), arguments.clips.end());
  if (!files.empty()) return files;
  return Status::Error(arguments.style + ": has no take, " + beside.string() +
                       "; expected that file, or --clip");
}

double Speed_m_s(const std::vector<Poses>& takes, double rate_hz) {
  double path_m = 0, steps = 0;
  for (const Poses& take : takes) {
    for (std::size_t i = 1; i < take.size(); ++i) {
      const body::Vec3 step = take[i].hips_position_m - take[i - 1].hips_position_m;
      path_m += std::hypot(static_cast<double>(step.x()), static_cast<double>(step.z()));
      steps += 1;
    }
  }
  return steps > 0 ? path_m / steps * rate_hz : 0;
}

// The built-in performers performing the act of that speed.
std::vector<Poses> Perform(double speed_m_s, double rate_hz, uint64_t seed, std::string& act) {
  const synthetic::Motion motion = speed_m_s < kStanding_m_s  ? synthetic::Motion::kStand
                                   : speed_m_s < kWalking_m_s ? synthetic::Motion::kWalk
                                                              : synthetic::Motion::kRun;
  act = synthetic::Name(motion);
  std::vector<Poses> all;
  for (int k = 0; k < kPerformers; ++k) {
    synthetic::Performer performer(
        synthetic::Vary(seed, static_cast<uint64_t>(k), {{motion, kPerformance_s}}));
    Poses& poses = all.emplace_back();
    for (int i = 0; i < static_cast<int>(kPerformance_s * rate_hz); ++i) {
      performer.Pose(i / rate_hz, poses.emplace_back());
    }
  }
  return all;
}

struct Session {
  LoadedStudent network;
  StyleFile style;
  RefineMotion motion;
  FullStyle start;
};

// Whether takes and neutral motion are mirrored, too.
bool MirrorsToo(const std::string& asked, const Frames& take, const Frames& neutral,
                const torch::Tensor& deviation) {
  const double asymmetry_cm =
      MeanDistance_cm(MomentsOf(take), MomentsOf(Mirrored(take)), deviation);
  const double style_cm = MeanDistance_cm(MomentsOf(take), MomentsOf(neutral), deviation);
  const bool symmetric = asymmetry_cm <= std::max(kAsymmetry_cm, kAsymmetry * style_cm);
  const bool mirrored = asked == "auto" ? symmetric : asked == "yes";
  std::printf(
      "the take's mean pose is %.1f cm from the neutral one, %.1f cm from its mirror image: %s\n",
      style_cm, asymmetry_cm, mirrored ? "mirrored, too" : "not mirrored");
  return mirrored;
}

void Append(const Frames& from, Frames& to) { to.insert(to.end(), from.begin(), from.end()); }

Status ReadMotion(const Arguments& arguments, Session& session) {
  const double rate_hz = static_cast<double>(session.network.network->model().rate_hz);
  const auto files = TakesOf(arguments);
  if (!files.ok()) return files.status();
  const auto takes = ReadAll(files.value(), rate_hz);
  if (!takes.ok()) return takes.status();
  double seconds = 0;
  for (const Poses& take : takes.value()) seconds += static_cast<double>(take.size()) / rate_hz;
  if (seconds < kLeast_s) {
    return Status::Error(files.value().front() + ": found " + NumberText(seconds, 2) +
                         " s, expected at least " + NumberText(kLeast_s));
  }
  const auto frames_of = [&session](const std::vector<Poses>& poses) {
    return FramesOf(poses, session.network.statistics, session.network.network->features());
  };
  const double speed_m_s = Speed_m_s(takes.value(), rate_hz);
  const Parts take = Split(frames_of(takes.value()), kJudgedShare);
  RefineMotion& motion = session.motion;
  motion.take = take.first;
  motion.judged_take = take.last;
  std::string act = "of --neutral";
  if (arguments.neutral.empty()) {
    const Frames all = frames_of(Perform(speed_m_s, rate_hz, arguments.config.seed, act));
    motion.neutral.assign(all.begin(), all.end() - 2);
    motion.judged_neutral.assign(all.end() - 2, all.end());
    act = "a built-in " + act;
  } else {
    const auto neutral = ReadAll(arguments.neutral, rate_hz);
    if (!neutral.ok()) return neutral.status();
    const Parts parts = Split(frames_of(neutral.value()), kJudgedShare);
    motion.neutral = parts.first;
    motion.judged_neutral = parts.last;
  }
  std::printf("%zu takes of %.1f s, %.2f m/s; neutral motion: %s\n", takes.value().size(), seconds,
              speed_m_s, act.c_str());
  const torch::Tensor deviation = torch::from_blob(session.network.statistics.deviation.data(),
                                                   {body::kJointCount, stgcn::kChannels});
  if (MirrorsToo(arguments.mirror, motion.take, motion.neutral, deviation)) {
    for (Frames* frames :
         {&motion.take, &motion.neutral, &motion.judged_take, &motion.judged_neutral}) {
      Append(Mirrored(*frames), *frames);
    }
  }
  return Status::Ok();
}

// The style of the file, or, with `--anew`, that of its first take as an example.
Status ReadStart(const Arguments& arguments, Session& session) {
  const st_gcn::Shape& shape = session.network.student->shape;
  const VectorSizes sizes(shape);
  std::vector<float> numbers = session.style.code;
  if (!sizes.Allow(numbers.size())) {
    return Status::Error(arguments.style + ": \"code\" has " + std::to_string(numbers.size()) +
                         " numbers; expected " + std::to_string(sizes.code) + ", " +
                         std::to_string(sizes.code + sizes.bias) + " or " +
                         std::to_string(sizes.full()));
  }
  if (arguments.anew) {
    const auto files = TakesOf(arguments);
    if (!files.ok()) return files.status();
    const auto poses = ReadPoses(files.value().front(),
                                 static_cast<double>(session.network.network->model().rate_hz));
    if (!poses.ok()) return poses.status();
    numbers = ExampleStyle(session.network, poses.value());
  }
  session.start = StyleOf(numbers, shape);
  return Status::Ok();
}

Result<Session> Open(const Arguments& arguments) {
  Session session;
  Result<StyleFile> style = ReadStyleFile(arguments.style);
  if (!style.ok()) return style.status();
  session.style = std::move(style.value());
  const auto weights = net::FindWeights(arguments.weights);
  if (!weights.ok()) return weights.status();
  const auto bytes = net::ReadFile(weights.value());
  if (!bytes.ok()) return bytes.status();
  char hash[32];
  std::snprintf(hash, sizeof hash, "crc32c:%08x", Crc32c(net::TensorBytes(bytes.value())));
  Result<LoadedStudent> network = ReadStudent(weights.value());
  if (!network.ok()) return network.status();
  session.network = std::move(network.value());
  if (session.style.weights != hash) {
    return Status::Error(arguments.style + ": was made with other weights, " +
                         session.style.weights + "; expected " + hash + " of " +
                         weights.value().string());
  }
  Status status = ReadStart(arguments, session);
  if (status.ok()) status = ReadMotion(arguments, session);
  if (!status.ok()) return status;
  return session;
}

std::string Text(const RefineFigures& figures) {
  char text[96];
  std::snprintf(text, sizeof text, "mean pose %5.2f cm, movement %5.2f cm off", figures.mean_cm,
                figures.spread_cm);
  return text;
}

nlohmann::json ToJson(const RefineFigures& figures) {
  return {{"mean_cm", figures.mean_cm}, {"movement_cm", figures.spread_cm}};
}

// The best style by its figures, among those evaluated every kReport_s.
struct Best {
  FullStyle style;
  RefineFigures figures;
};

Best Fit(const Arguments& arguments, Refiner& refiner, const Best& start, int64_t& steps) {
  Best best = start;
  const Clock::time_point begin = Clock::now();
  const double all_s = 60 * arguments.minutes;
  double loss = 0, report_s = kReport_s;
  int since = 0;
  const auto look = [&](double now_s) {
    const Best now{refiner.style(), refiner.Measure(refiner.style())};
    std::printf("%6.0f s, step %6lld: loss %.4f; %s\n", now_s, static_cast<long long>(steps),
                loss / std::max(since, 1), Text(now.figures).c_str());
    std::fflush(stdout);
    loss = since = 0;
    if (now.figures.score() < best.figures.score()) best = now;
  };
  while (!interrupted) {
    const double now_s = std::chrono::duration<double>(Clock::now() - begin).count();
    const double progress = arguments.iterations > 0 ? static_cast<double>(steps) /
                                                           static_cast<double>(arguments.iterations)
                                                     : now_s / all_s;
    if (progress >= 1) break;
    if (now_s >= report_s) {
      look(now_s);
      report_s = now_s + kReport_s;
    }
    loss += refiner.Step(progress);
    ++since;
    ++steps;
    if (!refiner.Finite()) {
      std::printf("the style is no longer finite; the best one so far is kept\n");
      return best;
    }
  }
  look(std::chrono::duration<double>(Clock::now() - begin).count());
  return best;
}

Status Run(const Arguments& arguments) {
  const Status checked = Check(arguments.config);
  if (!checked.ok()) return checked;
  Result<Session> opened = Open(arguments);
  if (!opened.ok()) return opened.status();
  Session& session = opened.value();
  Refiner refiner(arguments.config, session.network, session.motion, session.start);
  const Best start{session.start, refiner.Measure(session.start)};
  std::printf("on the last quarter of each take:\n  neutral: %s\n  start:   %s\n",
              Text(refiner.MeasureNeutral()).c_str(), Text(start.figures).c_str());
  std::fflush(stdout);
  int64_t steps = 0;
  const Best best = Fit(arguments, refiner, start, steps);
  if (!(best.figures.score() < start.figures.score())) {
    std::printf("no better than the start after %lld steps: nothing is written\n",
                static_cast<long long>(steps));
    return Status::Ok();
  }
  const std::string out = arguments.out.empty() ? arguments.style : arguments.out;
  session.style.code = VectorOf(best.style);
  session.style.all["refined"] = {
      {"steps", steps}, {"before", ToJson(start.figures)}, {"after", ToJson(best.figures)}};
  const Status written = WriteStyleFile(session.style, out);
  if (written.ok())
    std::printf("  now:     %s\nwritten: %s\n", Text(best.figures).c_str(), out.c_str());
  return written;
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  RefineConfig& config = arguments.config;
  app.add_option("style", arguments.style, "File of the style, LIBRARY/NAME.json")->required();
  app.add_option("--weights", arguments.weights,
                 "The weights that it was made with, family st-gcn-causal")
      ->required();
  app.add_option("--clip", arguments.clips, "More takes of the style (BVH), beside NAME.bvh");
  app.add_option("--neutral", arguments.neutral,
                 "Neutral motion of the same act (BVH); else a built-in performer's");
  app.add_option("--minutes", arguments.minutes, "How long")
      ->check(Number(0.01, 1e5))
      ->capture_default_str();
  app.add_option("--iterations", arguments.iterations, "Number of steps, instead of a time");
  app.add_option("--out", arguments.out, "Write to this file; default: the style's own");
  app.add_flag("--anew", arguments.anew, "Begin with the take as an example, not with the file");
  app.add_option("--mirror", arguments.mirror, "Fit mirror images, too; auto: if symmetric enough")
      ->check(CLI::IsMember({"auto", "yes", "no"}))
      ->capture_default_str();
  app.add_option("--seed", config.seed)
      ->check(Whole(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app.add_option("--batch", config.batch)->capture_default_str();
  app.add_option("--code-rate", config.code_rate)->capture_default_str();
  app.add_option("--rate", config.rate,
                 "Weight decay of bias and additions; 0: only the code is fitted")
      ->capture_default_str();
  app.add_option("--code-alone", config.code_alone,
                 "Share of the time in which only the code is fitted")
      ->capture_default_str();
  app.add_option("--w-moments", config.w_moments)->capture_default_str();
  app.add_option("--w-distribution", config.w_distribution)->capture_default_str();
  app.add_option("--w-reproduce", config.w_reproduce)->capture_default_str();
  app.add_option("--w-small", config.w_small)->capture_default_str();
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Fits a style to its takes, and writes a better style file.");
  AddOptions(app, arguments);
  if (const auto ended = Parse(app, argc, argv, net::DescribeDefaultWeights)) return *ended;
  setpriority(PRIO_PROCESS, 0, kNice);
  torch::set_num_threads(1);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { interrupted = true; });
  const Status status = Run(arguments);
  if (status.ok()) return 0;
  std::cerr << "stylerefine: " << status.message() << "\n";
  return 1;
}

}  // namespace
}  // namespace styled::train::st_gcn_causal

int main(int argc, char** argv) {
  styled::train::UseFastKernels(argv);
  return styled::train::st_gcn_causal::Main(argc, argv);
}
