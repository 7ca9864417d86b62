#include "model/train/judge/html.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string_view>

#include "model/body/humanoid.h"
#include "model/train/judge/nets.h"
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

std::vector<Scene> ScenesOf(const Data& data, const std::vector<Transferred>& baseline,
                            const std::vector<Transferred>& styled) {
  const auto frames = static_cast<std::size_t>(6 * kStreamRate_hz);
  const auto cut = [&](std::span<const body::Pose> poses) {
    return Thin(poses.first(std::min(poses.size(), frames)));
  };
  std::vector<Scene> scenes;
  for (std::size_t content = 0; content < data.manifest.contents.size(); ++content) {
    int longest = -1;
    for (std::size_t i = 0; i < data.inputs.size(); ++i) {
      if (data.contents[i] != static_cast<int>(content)) continue;
      if (longest < 0 || data.inputs[i].size() > data.inputs[longest].size()) {
        longest = static_cast<int>(i);
      }
    }
    for (const Transferred& of : styled.empty() ? baseline : styled) {
      if (of.clip != longest) continue;
      const auto offset = std::find_if(baseline.begin(), baseline.end(), [&of](const auto& other) {
        return other.clip == of.clip && other.style == of.style;
      });
      scenes.push_back({data.manifest.contents[content], data.manifest.styles[of.style].name,
                        cut(of.input), offset == baseline.end() ? Poses() : cut(offset->output),
                        styled.empty() ? Poses() : cut(of.output)});
    }
  }
  return scenes;
}

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
  constexpr std::string_view kPictures = "<!--PICTURES-->";
  std::string pictures;
  for (const Picture& picture : report.pictures) {
    pictures += "<h2>" + picture.title + "</h2>\n" + RenderPicture(picture);
  }
  constexpr std::string_view kPlace = "/*DATA*/null";
  std::string page = kReportPage;
  page.replace(page.find(kPictures), kPictures.size(), pictures);
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
