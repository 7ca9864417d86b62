#include "model/train/judge/strips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "model/body/heading.h"

namespace styled::judge {
namespace {

// Lengths in the picture are centimetres.
constexpr int kColumn = 110, kRow = 235, kFloor = 222, kCaption = 16;
constexpr float kView = 25 * std::numbers::pi_v<float> / 180;  // from the right toward the front
constexpr float kHeadLength_m = 0.16F;

struct Layer {
  const char* style;
  std::vector<std::vector<int>> chains;
};
// From back to front.
const std::array<Layer, 3>& Layers() {
  using namespace body;  // NOLINT: the names of joints
  static const std::array<Layer, 3> layers{
      {{"stroke:#246abe;stroke-width:4",
        {{kLeftUpperLeg, kLeftLowerLeg, kLeftFoot, kLeftToes},
         {kLeftShoulder, kLeftUpperArm, kLeftLowerArm, kLeftHand}}},
       {"stroke:#808080;stroke-width:4",
        {{kHips, kSpine, kChest, kNeck, kHead},
         {kLeftShoulder, kChest, kRightShoulder},
         {kLeftUpperLeg, kHips, kRightUpperLeg}}},
       {"stroke:#cd4632;stroke-width:4",
        {{kRightUpperLeg, kRightLowerLeg, kRightFoot, kRightToes},
         {kRightShoulder, kRightUpperArm, kRightLowerArm, kRightHand}}}}};
  return layers;
}

std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else {
      out += c;
    }
  }
  return out;
}

float Floor_m(const Poses& poses) {
  float lowest_m = 0;
  body::WorldPose world;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    body::ForwardKinematics(poses[i], world);
    lowest_m = i == 0 ? body::LowestFoot_m(world) : std::min(lowest_m, body::LowestFoot_m(world));
  }
  return lowest_m;
}

// One figure, its points relative to the floor under its hips.
class Figure {
 public:
  Figure(const body::Pose& pose, const body::Pose& seen_as, float floor_m, int column, int top)
      : hips_m_(pose.hips_position_m),
        floor_m_(floor_m),
        centre_(kColumn * static_cast<float>(column) + kColumn / 2.0F),
        ground_(static_cast<float>(top + kFloor)) {
    body::WorldPose source;
    body::ForwardKinematics(seen_as, source);
    across_rad_ = body::Heading_rad(source) + kView;
    body::ForwardKinematics(pose, world_);
  }
  std::string Path(const std::vector<int>& chain) const {
    std::string path;
    for (const int joint : chain) {
      path += path.empty() ? 'M' : 'L';
      path += Point(world_.positions_m[static_cast<std::size_t>(joint)]);
    }
    return path;
  }
  std::string Head() const {
    const body::Vec3& head = world_.positions_m[body::kHead];
    const body::Vec3 crown = head + world_.rotations[body::kHead] * body::Vec3(0, kHeadLength_m, 0);
    std::string path("M");
    path += Point(head);
    path += 'L';
    return path += Point(crown);
  }

 private:
  std::string Point(const body::Vec3& at_m) const {
    const body::Vec3 from_hips = at_m - hips_m_;
    const float x = from_hips.x() * std::sin(across_rad_) + from_hips.z() * std::cos(across_rad_);
    char text[32];
    std::snprintf(text, sizeof text, "%.1f,%.1f", centre_ + 100 * x,
                  ground_ - 100 * (at_m.y() - floor_m_));
    return text;
  }

  body::WorldPose world_;
  body::Vec3 hips_m_;
  float floor_m_, centre_, ground_, across_rad_ = 0;
};

std::string RenderStrip(const Strip& strip, const Picture& picture, int top) {
  const bool by_source = strip.source.size() >= strip.poses.size();
  const Poses& source = by_source ? strip.source : strip.poses;
  const float floor_m = Floor_m(source);
  std::vector<Figure> figures;
  for (int i = 0; i < picture.figures; ++i) {
    const std::size_t frame = strip.first + static_cast<std::size_t>(i) * picture.step;
    if (frame < strip.poses.size()) {
      figures.emplace_back(strip.poses[frame], source[frame], floor_m, i, top);
    }
  }
  std::string svg = "<path style=\"stroke:#a0a0a0;stroke-width:1\" d=\"M0," +
                    std::to_string(top + kFloor) + "H" + std::to_string(kColumn * picture.figures) +
                    "\"/>\n";
  for (const Layer& layer : Layers()) {
    std::string path;
    for (const Figure& figure : figures) {
      for (const std::vector<int>& chain : layer.chains) path += figure.Path(chain);
    }
    svg += std::string("<path style=\"") + layer.style + "\" d=\"" + path + "\"/>\n";
  }
  std::string heads;
  for (const Figure& figure : figures) heads += figure.Head();
  svg += "<path style=\"stroke:#808080;stroke-width:13\" d=\"" + heads + "\"/>\n";
  return svg + "<text x=\"4\" y=\"" + std::to_string(top + kCaption) +
         "\" style=\"stroke:none;fill:currentColor;font:14px sans-serif\">" +
         Escaped(strip.caption) + "</text>\n";
}

}  // namespace

std::string RenderPicture(const Picture& picture) {
  const int width = kColumn * picture.figures;
  const int height = kRow * static_cast<int>(picture.strips.size());
  std::string svg =
      "<svg viewBox=\"0 0 " + std::to_string(width) + " " + std::to_string(height) +
      "\" style=\"width:100%;fill:none;stroke-linecap:round;stroke-linejoin:round\">\n";
  for (std::size_t i = 0; i < picture.strips.size(); ++i) {
    svg += RenderStrip(picture.strips[i], picture, kRow * static_cast<int>(i));
  }
  return svg + "</svg>\n";
}

}  // namespace styled::judge
