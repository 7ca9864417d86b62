#include "model/train/judge/judge_html.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string_view>

#include "model/body/humanoid.h"
#include "model/train/judge/judge_nets.h"
#include "model/train/judge/report_page.h"

namespace styled::judge {
namespace {

std::string Base64(const std::vector<std::uint8_t>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? bytes[i + k] : 0);
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

// World positions of all joints, millimetres, little-endian int16, frame after frame.
std::string Track(const Poses& poses) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(poses.size() * body::kJointCount * 6);
  body::WorldPose world;
  for (const body::Pose& pose : poses) {
    body::ForwardKinematics(pose, world);
    for (const body::Vec3& position_m : world.positions_m) {
      for (int axis = 0; axis < 3; ++axis) {
        const float mm = std::clamp(std::round(1000 * position_m[axis]), -32767.0F, 32767.0F);
        const auto bits = static_cast<std::uint16_t>(static_cast<std::int16_t>(mm));
        bytes.push_back(static_cast<std::uint8_t>(bits & 0xFF));
        bytes.push_back(static_cast<std::uint8_t>(bits >> 8));
      }
    }
  }
  return Base64(bytes);
}

}  // namespace

std::string RenderReport(const Report& report) {
  nlohmann::json data = {{"weights", report.weights},
                         {"manifest", report.manifest},
                         {"figures", report.figures},
                         {"rate_hz", kJudgeRate_hz},
                         {"head", static_cast<int>(body::kHead)},
                         {"scenes", nlohmann::json::array()}};
  for (const body::JointRow& row : body::kHumanoid) data["parents"].push_back(row.parent);
  for (const Scene& scene : report.scenes) {
    data["scenes"].push_back({{"content", scene.content},
                              {"style", scene.style},
                              {"input", Track(scene.input)},
                              {"offset", Track(scene.offset)},
                              {"styled", Track(scene.styled)}});
  }
  // "</" in a name would end the script element.
  std::string text = data.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = text.find("</"); at != std::string::npos; at = text.find("</", at)) {
    text.insert(at + 1, 1, '\\');
  }
  constexpr std::string_view kPlace = "/*DATA*/null";
  std::string page = kReportPage;
  page.replace(page.find(kPlace), kPlace.size(), text);
  return page;
}

Status WriteReport(const Report& report, const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary);
  out << RenderReport(report);
  if (!out.flush()) return Status::Error(file.string() + ": cannot be written");
  return Status::Ok();
}

}  // namespace styled::judge
