#include "model/tools/stylize/preview.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <utility>

#include "model/base/descriptor.h"
#include "model/base/text.h"
#include "model/body/heading.h"
#include "model/tools/strips/canvas.h"
#include "model/tools/strips/figure.h"

extern char** environ;  // NOLINT: as POSIX names it

namespace styled::stylize {
namespace {

using strips::Canvas;
using strips::Place;

bool IsFilm(const std::string& file) { return std::filesystem::path(file).extension() == ".mp4"; }

// The program in PATH, "" if it is not there.
std::string FindProgram(const char* name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string file = (folder.empty() ? "." : folder) + "/" + name;
    if (access(file.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(file)) return file;
  }
  return "";
}

float Floor_m(const std::vector<body::Pose>& poses) {
  float floor_m = 1e9F;
  body::WorldPose world;
  for (const body::Pose& pose : poses) {
    body::ForwardKinematics(pose, world);
    floor_m = std::min(floor_m, body::LowestFoot_m(world));
  }
  return floor_m;
}

float Heading_rad(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return body::Heading_rad(world);
}

const body::Pose& At(const std::vector<body::Pose>& poses, double share) {
  return poses[static_cast<std::size_t>(
      std::lround(share * static_cast<double>(poses.size() - 1)))];
}

Status WriteStrip(const Shown& shown, const std::string& file) {
  constexpr int kFigures = 12, kColumn_px = 96, kRow_px = 210, kMargin_px = 24;
  Canvas canvas(2 * kMargin_px + kFigures * kColumn_px, 4 * kRow_px + kMargin_px);
  struct Row {
    const char* view;
    bool output;
    float view_rad;
  };
  constexpr std::array<Row, 4> kRows{{{"from the right", false, strips::kFromTheRight_rad},
                                      {"from the right", true, strips::kFromTheRight_rad},
                                      {"from the front", false, 0},
                                      {"from the front", true, 0}}};
  const float input_floor_m = Floor_m(shown.input), output_floor_m = Floor_m(shown.output);
  for (std::size_t row = 0; row < kRows.size(); ++row) {
    const auto& [view, output, view_rad] = kRows[row];
    const float top_px = static_cast<float>(row) * kRow_px;
    canvas.Text(kMargin_px, top_px + 8, (output ? shown.style : "input") + std::string(" ") + view,
                2, strips::kTrunk);
    Place place;
    place.floor_px = top_px + kRow_px - 4;
    place.view_rad = view_rad;
    place.floor_m = output ? output_floor_m : input_floor_m;
    canvas.Line(kMargin_px, place.floor_px + 2, static_cast<float>(canvas.width() - kMargin_px),
                place.floor_px + 2, 1, strips::kFloor);
    for (int i = 0; i < kFigures; ++i) {
      const double share = static_cast<double>(i) / (kFigures - 1);
      place.centre_px = kMargin_px + (static_cast<float>(i) + 0.5F) * kColumn_px;
      // Both have the input's heading, so that they can be compared.
      place.heading_rad = Heading_rad(At(shown.input, share));
      strips::DrawFigure(At(output ? shown.output : shown.input, share), place, canvas);
    }
  }
  return canvas.WritePng(file);
}

// ffmpeg, which reads pictures from a pipe.
class Film {
 public:
  Film(const std::string& file, int width, int height, double rate_hz) {
    const std::string program = FindProgram("ffmpeg");
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    std::vector<std::string> words{program,     "-v",         "error",    "-y",
                                   "-f",        "rawvideo",   "-pix_fmt", "rgb24",
                                   "-s",        size,         "-r",       NumberText(rate_hz),
                                   "-i",        "-",          "-pix_fmt", "yuv420p",
                                   "-movflags", "+faststart", file};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC) != 0) return;
    const Descriptor reading(ends[0]);
    to_ = ends[1];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, reading.get(), STDIN_FILENO);
    if (posix_spawn(&child_, program.c_str(), &actions, nullptr, arguments.data(), environ) != 0) {
      child_ = -1;
    }
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Film() { (void)End(); }
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  bool Add(const Canvas& canvas) const {
    std::size_t at = 0;
    const auto& pixels = canvas.pixels();
    while (child_ > 0 && at < pixels.size()) {
      const ssize_t written = write(to_, pixels.data() + at, pixels.size() - at);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      at += static_cast<std::size_t>(written);
    }
    return child_ > 0;
  }
  // Whether ffmpeg succeeded.
  bool End() {
    if (to_ >= 0) close(std::exchange(to_, -1));
    int status = 1;
    if (child_ > 0) waitpid(std::exchange(child_, -1), &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  int to_ = -1;
  pid_t child_ = -1;
};

Status WriteFilm(const Shown& shown, const std::string& file) {
  constexpr int kWidth_px = 640, kHeight_px = 400;
  constexpr float kScale_px = 160, kView_rad = 0.6F;  // from the front and a little from the side
  constexpr double kMost_hz = 30;
  const double duration_s = static_cast<double>(shown.output.size()) / shown.rate_hz;
  const double rate_hz = std::min(kMost_hz, shown.rate_hz);
  const auto pictures = std::max<std::size_t>(1, static_cast<std::size_t>(duration_s * rate_hz));
  // A reader that ends early is an error of the write, not of this program.
  std::signal(SIGPIPE, SIG_IGN);
  Film film(file, kWidth_px, kHeight_px, rate_hz);
  const float heading_rad = Heading_rad(shown.input.front());
  const float input_floor_m = Floor_m(shown.input), output_floor_m = Floor_m(shown.output);
  bool good = true;
  for (std::size_t i = 0; good && i < pictures; ++i) {
    Canvas canvas(kWidth_px, kHeight_px);
    const double share =
        pictures > 1 ? static_cast<double>(i) / static_cast<double>(pictures - 1) : 0;
    for (const bool output : {false, true}) {
      const float centre_px = (output ? 0.75F : 0.25F) * kWidth_px;
      Place place{centre_px,   kHeight_px - 30, kScale_px,
                  heading_rad, kView_rad,       output ? output_floor_m : input_floor_m};
      canvas.Text(centre_px - 140, 10, output ? shown.style : "input", 2, strips::kTrunk);
      canvas.Line(centre_px - 140, kHeight_px - 28, centre_px + 140, kHeight_px - 28, 1,
                  strips::kFloor);
      strips::DrawFigure(At(output ? shown.output : shown.input, share), place, canvas);
    }
    good = film.Add(canvas);
  }
  good = film.End() && good;
  return good ? Status::Ok() : Status::Error(file + ": ffmpeg did not write it");
}

}  // namespace

Status CanPreview(const std::string& file) {
  if (!IsFilm(file) || !FindProgram("ffmpeg").empty()) return Status::Ok();
  return Status::Error("--preview " + file +
                       ": found no program ffmpeg in PATH, which writes .mp4; expected it, or a "
                       ".png");
}

Status WritePreview(const Shown& shown, const std::string& file) {
  return IsFilm(file) ? WriteFilm(shown, file) : WriteStrip(shown, file);
}

}  // namespace styled::stylize
