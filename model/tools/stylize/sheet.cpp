#include "model/tools/stylize/sheet.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "model/base/text.h"
#include "model/clip/clip.h"
#include "model/tools/stylize/sheet_page.h"

namespace styled::stylize {
namespace {

using SheetJson = nlohmann::json;

std::string Base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (i + k < bytes.size() ? bytes[i + k] : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

// The first seconds of a motion, at the sheet's rate.
std::vector<body::Pose> Begin(const SheetMotion& motion) {
  const auto most = static_cast<std::size_t>(Sheet::kShown_s * motion.rate_hz) + 1;
  std::vector<body::Pose> poses(
      motion.poses.begin(),
      motion.poses.begin() + static_cast<std::ptrdiff_t>(std::min(most, motion.poses.size())));
  return clip::ResamplePoses(poses, motion.rate_hz, Sheet::kRate_hz);
}

// Joint by joint x, y, z as millimetres in 16 bits, little end first. The origin is on the floor,
// below the first pose's hips.
class Points {
 public:
  explicit Points(const std::vector<body::Pose>& poses) {
    worlds_.resize(poses.size());
    floor_m_ = 1e9F;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      body::ForwardKinematics(poses[i], worlds_[i]);
      floor_m_ = std::min(floor_m_, body::LowestFoot_m(worlds_[i]));
    }
    origin_m_ = worlds_.front().positions_m[body::kHips];
    origin_m_.y() = 0;
  }
  const body::Vec3& origin_m() const { return origin_m_; }
  // Relative to another motion's origin.
  std::string Text(const body::Vec3& origin_m) const {
    std::vector<std::uint8_t> bytes;
    for (const body::WorldPose& world : worlds_) {
      for (const body::Vec3& place_m : world.positions_m) {
        const body::Vec3 from = place_m - origin_m - body::Vec3(0, floor_m_, 0);
        for (const float value_m : from) {
          const auto mm = static_cast<std::int16_t>(
              std::lround(std::clamp(1000 * value_m, -32767.0F, 32767.0F)));
          bytes.push_back(static_cast<std::uint8_t>(mm & 0xFF));
          bytes.push_back(static_cast<std::uint8_t>(mm >> 8 & 0xFF));
        }
      }
    }
    return Base64(bytes);
  }

 private:
  std::vector<body::WorldPose> worlds_;
  body::Vec3 origin_m_;
  float floor_m_;
};

}  // namespace

void Sheet::Add(const Outcome& outcome, const SheetMotion& input, const SheetMotion& output) {
  if (rows_.empty() || last_ != outcome.in) {
    rows_.push_back({{"clip", outcome.in}, {"cells", SheetJson::array()}});
    last_ = outcome.in;
  }
  SheetJson& row = rows_.back();
  SheetJson cell{{"style", outcome.style}};
  if (!outcome.error.empty()) {
    cell["error"] = outcome.error;
    row["cells"].push_back(std::move(cell));
    return;
  }
  ++outputs_;
  const Points before(Begin(input));
  if (!row.contains("input")) {
    row["seconds"] = static_cast<double>(input.poses.size() - 1) / input.rate_hz;
    row["input"] = before.Text(before.origin_m());
  }
  cell["figure"] = Points(Begin(output)).Text(before.origin_m());
  cell["numbers"] = FigureLines(outcome);
  if (const std::string warning = SlideWarning(outcome); !warning.empty()) {
    cell["warning"] = warning;
  }
  row["cells"].push_back(std::move(cell));
}

Status Sheet::Write(const std::string& file) const {
  SheetJson bones = SheetJson::array();
  for (int joint = 1; joint < body::kJointCount; ++joint) {
    bones.push_back({body::kHumanoid[static_cast<std::size_t>(joint)].parent, joint});
  }
  const SheetJson data{{"rate_hz", kRate_hz},
                       {"shown_s", kShown_s},
                       {"joints", body::kJointCount},
                       {"bones", bones},
                       {"rows", rows_}};
  std::string text = data.dump(-1, ' ', false, SheetJson::error_handler_t::replace);
  // A name like </script> must not end the script's data.
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
    text.replace(at, 1, "\\u003c");
  }
  std::string page = kSheetPage;
  const std::size_t place = page.find(kSheetPlace);
  page.replace(place, kSheetPlace.size(), text);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "wb"),
                                                               &std::fclose);
  const bool good = stream &&
                    std::fwrite(page.data(), 1, page.size(), stream.get()) == page.size() &&
                    std::fflush(stream.get()) == 0;
  const int reason = errno;
  return good ? Status::Ok()
              : Status::Error(file +
                              ": cannot be written: " + std::generic_category().message(reason));
}

}  // namespace styled::stylize
