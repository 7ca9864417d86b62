// WriteBvh and FormatBvh: rotations become Euler angles again, continuous along the clip.
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <system_error>

#include "model/base/text.h"
#include "model/clip/clip.h"

namespace styled::clip {
namespace {

using rig::Vec3;
using Angles = std::array<double, 3>;  // radians, in channel order

bool IsRotation(char kind) { return kind >= 'x'; }

// `angle` plus the whole turns that bring it nearest to `near`.
double Unwrap(double angle, double near) {
  return near + std::remainder(angle - near, 2 * std::numbers::pi);
}

// Decomposes a rotation into turns about up to three different axes, in channel order (intrinsic).
class EulerSolver {
 public:
  explicit EulerSolver(const std::string& channels) {
    for (char kind : channels) {
      if (IsRotation(kind) && count_ < 3) axis_[count_++] = kind - 'x';
    }
    // The third axis completes the three; the sign tells whether their order is cyclic (XYZ, YZX,
    // ZXY) or reversed.
    if (count_ == 2) axis_[2] = 3 - axis_[0] - axis_[1];
    if (count_ >= 2) sign_ = (axis_[0] + 1) % 3 == axis_[1] ? 1.0 : -1.0;
  }

  int count() const { return count_; }

  // R = Ri(a) Rj(b) Rk(c) has two solutions. Returns the one nearer to `previous`, unwrapped;
  // without `previous` the one with b within a quarter turn. At the gimbal lock (b is a quarter
  // turn) a stays as it was.
  Angles Solve(const Eigen::Quaterniond& q, const Angles* previous) const {
    if (count_ == 0) return {};
    const Angles near = previous != nullptr ? *previous : Angles{};
    if (count_ == 1) return {Unwrap(2 * std::atan2(q.vec()[axis_[0]], q.w()), near[0])};
    const Eigen::Matrix3d m = q.toRotationMatrix();
    const auto [i, j, k] = axis_;
    if (count_ == 2) {
      return {Unwrap(std::atan2(sign_ * m(k, j), m(j, j)), near[0]),
              Unwrap(std::atan2(sign_ * m(i, k), m(i, i)), near[1])};
    }
    // At the gimbal lock only a + c or a - c is determined; a itself is only rounding.
    const bool gimbal = std::hypot(m(i, i), m(i, j)) < 1e-6;
    const double a = gimbal ? near[0] : std::atan2(-sign_ * m(j, k), m(k, k));
    const Angles first = Complete(m, a, near);
    if (previous == nullptr || gimbal) return first;
    const Angles second = Complete(m, a + std::numbers::pi, near);
    return Distance(first, near) <= Distance(second, near) ? first : second;
  }

 private:
  // Finds b and c for a given a, from Ri(-a) R = Rj(b) Rk(c).
  Angles Complete(const Eigen::Matrix3d& m, double a, const Angles& near) const {
    const auto [i, j, k] = axis_;
    const double cosine = std::cos(a), sine = sign_ * std::sin(a);
    const Eigen::RowVector3d row_j = cosine * m.row(j) + sine * m.row(k);
    const double b = std::atan2(sign_ * m(i, k), cosine * m(k, k) - sine * m(j, k));
    const double c = std::atan2(sign_ * row_j[i], row_j[j]);
    return {Unwrap(a, near[0]), Unwrap(b, near[1]), Unwrap(c, near[2])};
  }
  static double Distance(const Angles& a, const Angles& b) {
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
  }

  std::array<int, 3> axis_{};
  int count_ = 0;
  double sign_ = 1.0;
};

void Append(std::string& text, double value, int decimals = 6) {
  std::array<char, 352> digits;  // enough for every double in fixed notation
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                    std::chars_format::fixed, decimals);
  std::string_view word(digits.data(), result.ptr - digits.data());
  if (word == "-0.000000") word.remove_prefix(1);
  text += word;
}

void AppendOffset(std::string& text, const std::string& indent, const Vec3& offset) {
  text += indent + "OFFSET";
  for (float value : offset) {
    text += ' ';
    Append(text, value);
  }
  text += '\n';
}

class Writer {
 public:
  explicit Writer(const Clip& clip) : clip_(clip), channels_(clip.channels) {
    const std::size_t joints = clip.skeleton.names.size();
    channels_.resize(joints);
    if (clip.channels.empty()) {
      for (std::size_t joint = 0; joint < joints; ++joint) {
        channels_[joint] = joint == 0 ? "XYZzxy" : "zxy";
      }
    }
    children_.resize(joints);
    for (std::size_t joint = 1; joint < joints; ++joint) {
      children_[clip.skeleton.parents[joint]].push_back(static_cast<int>(joint));
    }
  }

  std::string Run() {
    text_ = "HIERARCHY\n";
    if (!children_.empty()) Hierarchy();
    Motion();
    return std::move(text_);
  }

 private:
  // Depth first with an explicit stack, so that the length of a chain is not limited. If the clip's
  // order is depth first, as in every clip read from a file, joints are written in that order.
  void Hierarchy() {
    struct Open {
      int joint;
      std::size_t next_child = 0;
    };
    std::vector<Open> open;
    Begin(0, 0);
    open.push_back({0});
    while (!open.empty()) {
      Open& top = open.back();
      if (top.next_child < children_[top.joint].size()) {
        const int child = children_[top.joint][top.next_child++];
        Begin(child, open.size());
        open.push_back({child});
      } else {
        End(top.joint, open.size() - 1);
        open.pop_back();
      }
    }
  }

  void Begin(int joint, std::size_t depth) {
    order_.push_back(joint);
    const std::string indent(depth, '\t');
    text_ += indent + (depth == 0 ? "ROOT " : "JOINT ") + clip_.skeleton.names[joint] + "\n" +
             indent + "{\n";
    AppendOffset(text_, indent + "\t", clip_.skeleton.offsets[joint]);
    text_ += indent + "\tCHANNELS " + std::to_string(channels_[joint].size());
    for (char kind : channels_[joint]) {
      const char axis = static_cast<char>(IsRotation(kind) ? kind - 'x' + 'X' : kind);
      text_ += std::string(" ") + axis + (IsRotation(kind) ? "rotation" : "position");
    }
    text_ += '\n';
  }

  void End(int joint, std::size_t depth) {
    const std::string indent(depth, '\t');
    std::vector<Vec3> sites;
    if (static_cast<std::size_t>(joint) < clip_.end_sites.size()) sites = clip_.end_sites[joint];
    // Many readers expect an End Site at the end of every chain.
    if (sites.empty() && children_[joint].empty()) sites.emplace_back(Vec3::Zero());
    for (const Vec3& site : sites) {
      text_.append(indent).append("\tEnd Site\n").append(indent).append("\t{\n");
      AppendOffset(text_, indent + "\t\t", site);
      text_ += indent + "\t}\n";
    }
    text_ += indent + "}\n";
  }

  void Motion() {
    text_ += "MOTION\nFrames: " + std::to_string(clip_.frames.size()) + "\nFrame Time: ";
    Append(text_, 1.0 / clip_.rate_hz, 9);
    text_ += '\n';

    std::vector<EulerSolver> solvers;
    solvers.reserve(channels_.size());
    for (const std::string& channels : channels_) solvers.emplace_back(channels);
    std::vector<Angles> angles(channels_.size());
    for (std::size_t frame = 0; frame < clip_.frames.size(); ++frame) {
      const rig::RigPose& pose = clip_.frames[frame];
      const std::size_t row = text_.size();
      for (int joint : order_) {
        angles[joint] = solvers[joint].Solve(pose.rotations[joint].cast<double>().normalized(),
                                             frame == 0 ? nullptr : &angles[joint]);
        int turn = 0;
        for (char kind : channels_[joint]) {
          if (text_.size() > row) text_ += ' ';
          if (IsRotation(kind)) {
            Append(text_, angles[joint][turn++] * (180.0 / std::numbers::pi));
          } else {
            Append(text_, pose.translations[joint][kind - 'X']);
          }
        }
      }
      text_ += '\n';
    }
  }

  const Clip& clip_;
  std::vector<std::string> channels_;
  std::vector<std::vector<int>> children_;
  std::vector<int> order_;
  std::string text_;
};

}  // namespace

std::string FormatBvh(const Clip& clip) { return Writer(clip).Run(); }

Status WriteBvh(const Clip& clip, const std::filesystem::path& file) {
  if (clip.skeleton.joint_count() == 0 || clip.frames.empty()) {
    return Status::Error(file.string() + ": found a clip without joints or frames, expected both");
  }
  if (!(clip.rate_hz >= 1 && clip.rate_hz <= 1000)) {
    return Status::Error(file.string() + ": found a rate of " + NumberText(clip.rate_hz) +
                         " Hz, expected 1 to 1000");
  }
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "wb"),
                                                         &std::fclose);
  if (!stream) {
    return Status::Error(file.string() + ": cannot be opened for writing: " +
                         std::generic_category().message(errno));
  }
  const std::string text = FormatBvh(clip);
  const bool written = std::fwrite(text.data(), 1, text.size(), stream.get()) == text.size();
  if (std::fclose(stream.release()) != 0 || !written) {
    return Status::Error(file.string() + ": found no room for " + std::to_string(text.size()) +
                         " bytes, expected the whole clip to fit");
  }
  return Status::Ok();
}

}  // namespace styled::clip
