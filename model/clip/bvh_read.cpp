// ReadBvh and ParseBvh. One pass over the text, no stream, no locale.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "model/base/text.h"
#include "model/clip/clip.h"
#include "model/clip/plain_text.h"

namespace styled::clip {
namespace {

using rig::Quat;
using rig::Vec3;

constexpr int kMaxJoints = rig::kMaxSourceJoints;  // no binding has more
constexpr std::size_t kMaxName = 256;              // bytes
// Frames take at most this many bytes for each byte of text, in addition to a fixed allowance. For
// the densest text of rotations, "0 0 0 " per joint, they take 5.
constexpr std::size_t kFrameBytesPerByte = 6;
constexpr std::size_t kFramesAllowance = std::size_t{2} << 20;
constexpr int kOthersShown = 3;               // skeletons that are not read, in a remark
constexpr std::uint64_t kRowsPerCheck = 256;  // of the time limit

char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

bool SameWord(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (Lower(a[i]) != Lower(b[i])) return false;
  }
  return true;
}

constexpr const char* kNumber = "a number within 1e9 of 0";

bool ToDouble(std::string_view word, double& value) {
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() &&
         std::abs(value) < 1e9;  // false for NaN as well
}

// "0,5", as programs write it where that is usual.
bool CommaToDouble(std::string_view word, double& value) {
  std::array<char, 64> point;
  const std::size_t comma = word.find(',');
  if (comma == std::string_view::npos || word.size() > point.size()) return false;
  if (word.find(',', comma + 1) != std::string_view::npos) return false;
  if (word.find('.') != std::string_view::npos) return false;
  std::copy(word.begin(), word.end(), point.begin());
  point[comma] = '.';
  return ToDouble({point.data(), word.size()}, value);
}

// "nan", "-inf", "1.#QNAN": printed by programs instead of a number.
bool IsNoNumber(std::string_view word) {
  if (!word.empty() && (word[0] == '+' || word[0] == '-')) word.remove_prefix(1);
  const std::string_view begin = word.substr(0, 3);
  return SameWord(begin, "nan") || SameWord(begin, "inf") || word.starts_with("1.#");
}

// Splits the text into words and lines, which end with LF, CRLF or CR.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;  // byte order mark
  }

  int line() const { return line_; }
  std::size_t left() const { return text_.size() - at_; }

  // The next word, across line ends; empty at the end of the text. "{" and "}" are words.
  std::string_view Word() {
    while (at_ < text_.size() && (IsBlank(text_[at_]) || text_[at_] == '\n')) {
      if (AtLineEnd()) ++line_;
      ++at_;
    }
    return ReadWord();
  }
  // The next word on this line; empty if there is none.
  std::string_view WordOnLine() {
    SkipBlanks();
    return at_ < text_.size() && !AtLineEnd() ? ReadWord() : std::string_view();
  }
  // The rest of this line without surrounding blanks, up to a brace, which is not consumed.
  std::string_view RestOfLine() {
    SkipBlanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !AtLineEnd() && text_[at_] != '{' && text_[at_] != '}') {
      ++at_;
    }
    std::size_t end = at_;
    while (end > begin && IsBlank(text_[end - 1])) --end;
    return text_.substr(begin, end - begin);
  }

 private:
  bool AtLineEnd() const {
    return text_[at_] == '\n' ||
           (text_[at_] == '\r' && (at_ + 1 == text_.size() || text_[at_ + 1] != '\n'));
  }
  void SkipBlanks() {
    while (at_ < text_.size() && IsBlank(text_[at_]) && !AtLineEnd()) ++at_;
  }
  std::string_view ReadWord() {
    const std::size_t begin = at_;
    if (at_ < text_.size() && (text_[at_] == '{' || text_[at_] == '}')) {
      return text_.substr(at_++, 1);
    }
    while (at_ < text_.size() && !IsBlank(text_[at_]) && text_[at_] != '\n' && text_[at_] != '{' &&
           text_[at_] != '}') {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

// A word for an error message: printable and short.
std::string Quote(std::string_view word) {
  if (word.empty()) return "the end";
  std::string quoted = "\"";
  for (char c : word.substr(0, 40)) quoted += c >= ' ' && c <= '~' ? c : '?';
  return quoted + (word.size() > 40 ? "...\"" : "\"");
}

// Frame times are rounded: 0.0333333 s means 30 Hz. A rate within a ten-thousandth of a whole or
// NTSC rate is replaced by that rate.
double NearestRate(double rate_hz) {
  const double whole = std::round(rate_hz);
  const double ntsc = std::round(rate_hz * 1.001) * 1000.0 / 1001.0;
  for (double nominal : {whole, ntsc}) {
    if (nominal >= 1 && std::abs(rate_hz / nominal - 1) < 1e-4) return nominal;
  }
  return rate_hz;
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& name, const ReadLimits& limits)
      : scan_(text), name_(name), limits_(limits), size_(text.size()) {}

  Result<Clip> Run() {
    if (!Hierarchy() || !Motion() || !Repair()) return Status::Error(error_);
    return std::move(clip_);
  }

 private:
  bool Fail(const std::string& found, const std::string& expected) {
    return FailIn(scan_.line(), found, expected);
  }
  bool FailIn(int line, const std::string& found, const std::string& expected) {
    error_ = name_ + ":" + std::to_string(line) + ": found " + found + ", expected " + expected;
    return false;
  }
  bool Refuse(std::string error) {
    error_ = std::move(error);
    return false;
  }
  // Adds to the clip's remark.
  void Remark(const std::string& text) {
    if (clip_.remark.find(text) != std::string::npos) return;
    clip_.remark.append(clip_.remark.empty() ? "" : "; ").append(text);
  }
  bool Number(std::string_view word, double& value) {
    if (ToDouble(word, value)) return true;
    if (!CommaToDouble(word, value)) return false;
    Remark("decimal commas are read as points");
    return true;
  }
  bool Expect(std::string_view keyword) {
    const std::string_view word = scan_.Word();
    return SameWord(word, keyword) || Fail(Quote(word), std::string(keyword));
  }
  bool Offset(Vec3& offset) {
    for (int axis = 0; axis < 3; ++axis) {
      double value = 0;
      const std::string_view word = scan_.Word();
      if (!Number(word, value)) {
        return Fail(Quote(word), std::string("three OFFSET values, each ") + kNumber);
      }
      offset[axis] = static_cast<float>(value);
    }
    return true;
  }

  bool Hierarchy() {
    if (!Expect("HIERARCHY")) return false;
    std::string_view root = scan_.Word();
    if (!SameWord(root, "ROOT")) return Fail(Quote(root), "ROOT");
    for (; SameWord(root, "ROOT"); root = scan_.Word()) {
      if (!Root()) return false;
    }
    return SameWord(root, "MOTION") || Fail(Quote(root), "MOTION");
  }

  bool Root() {
    std::vector<int> open;
    if (!Joint(-1, open)) return false;
    while (!open.empty()) {
      const int joint = open.back();
      const std::string_view word = scan_.Word();
      if (SameWord(word, "OFFSET")) {
        if (!Offset(clip_.skeleton.offsets[joint])) return false;
      } else if (SameWord(word, "CHANNELS")) {
        if (!Channels(joint)) return false;
      } else if (SameWord(word, "JOINT")) {
        if (!Joint(joint, open)) return false;
      } else if (SameWord(word, "End")) {
        if (!EndSite(joint)) return false;
      } else if (word == "}") {
        open.pop_back();
      } else {
        return Fail(Quote(word), "OFFSET, CHANNELS, JOINT, End Site or }");
      }
    }
    return true;
  }

  bool Joint(int parent, std::vector<int>& open) {
    const std::string_view joint_name = scan_.RestOfLine();
    if (joint_name.empty()) return Fail("no name", "a joint name");
    if (clip_.skeleton.joint_count() >= kMaxJoints) {
      return Fail("one more joint", "at most " + std::to_string(kMaxJoints));
    }
    if (joint_name.size() > kMaxName) {
      return Fail("a joint name of " + std::to_string(joint_name.size()) + " bytes",
                  "at most " + std::to_string(kMaxName));
    }
    if (!Expect("{")) return false;
    open.push_back(clip_.skeleton.joint_count());
    clip_.skeleton.names.emplace_back(joint_name);
    clip_.skeleton.parents.push_back(parent);
    clip_.skeleton.offsets.emplace_back(Vec3::Zero());
    clip_.channels.emplace_back();
    clip_.end_sites.emplace_back();
    return true;
  }

  bool EndSite(int joint) {
    Vec3 offset = Vec3::Zero();
    scan_.RestOfLine();  // "Site", or its name
    if (!Expect("{") || !Expect("OFFSET") || !Offset(offset) || !Expect("}")) return false;
    clip_.end_sites[joint].push_back(offset);
    return true;
  }

  bool Channels(int joint) {
    static constexpr std::pair<std::string_view, char> kKinds[] = {
        {"Xposition", 'X'}, {"Yposition", 'Y'}, {"Zposition", 'Z'},
        {"Xrotation", 'x'}, {"Yrotation", 'y'}, {"Zrotation", 'z'},
    };
    std::string& channels = clip_.channels[joint];
    if (!channels.empty()) return Fail("CHANNELS again", "them once per joint");
    const std::string_view count_word = scan_.Word();
    double count = 0;
    if (!Number(count_word, count) || !(count >= 0 && count <= 6) || count != std::floor(count)) {
      return Fail(Quote(count_word), "0 to 6 channels");
    }
    for (int i = 0; i < static_cast<int>(count); ++i) {
      const std::string_view word = scan_.Word();
      char kind = 0;
      for (const auto& [name, letter] : kKinds) {
        if (SameWord(word, name)) kind = letter;
      }
      if (kind == 0) return Fail(Quote(word), "a channel such as Xposition or Zrotation");
      if (channels.find(kind) != std::string::npos) {
        return Fail(Quote(word) + " twice", "each channel of a joint once");
      }
      channels += kind;
    }
    channel_count_ += channels.size();
    return true;
  }

  // The word after "Name:", which may be written "Name :" and without a blank behind it.
  bool Label(std::string_view name, std::string_view& value) {
    std::string_view word = scan_.Word();
    if (!SameWord(word.substr(0, name.size()), name)) {
      return Fail(Quote(word), std::string(name) + ":");
    }
    word.remove_prefix(name.size());
    if (word.empty()) word = scan_.Word();
    if (!word.starts_with(':')) return Fail(Quote(word), std::string(name) + ":");
    word.remove_prefix(1);
    value = word.empty() ? scan_.Word() : word;
    return true;
  }

  bool Motion() {
    if (channel_count_ == 0) return Fail("no channels in any joint", "at least one");
    std::string_view frames_word;
    if (!Label("Frames", frames_word)) return false;
    std::uint64_t frames = 0;
    const auto parsed =
        std::from_chars(frames_word.data(), frames_word.data() + frames_word.size(), frames);
    if (parsed.ec != std::errc() || parsed.ptr != frames_word.data() + frames_word.size()) {
      return Fail(Quote(frames_word), "a number of frames");
    }

    if (!Expect("Frame")) return false;
    double frame_time_s = 0;
    std::string_view time_word;
    if (!Label("Time", time_word)) return false;
    // Slightly wider than the limits, because frame times are rounded.
    if (!Number(time_word, frame_time_s) || !(frame_time_s > 0.000999 && frame_time_s < 1.001)) {
      return Fail(Quote(time_word), "a frame time of 0.001 to 1 s");
    }
    clip_.rate_hz = NearestRate(1.0 / frame_time_s);

    // A value needs at least two characters, so the size of the text limits the memory that a wrong
    // frame count can reserve.
    const std::uint64_t most = scan_.left() / (2 * channel_count_) + 1;
    if (frames <= most && !FramesFit(std::min(frames, FramesWanted()))) return false;
    clip_.frames.reserve(std::min({frames, most, MostFrames(), FramesWanted()}));
    return Rows(frames);
  }

  // Joints without channels take memory per frame but no text, so the memory is limited, too.
  std::uint64_t MostFrames() const {
    return (kFrameBytesPerByte * size_ + kFramesAllowance) /
           FrameBytes(clip_.skeleton.names.size());
  }
  bool FramesFit(std::uint64_t frames) {
    return frames <= MostFrames() ||
           Fail(std::to_string(frames) + " frames of " +
                    std::to_string(clip_.skeleton.names.size()) + " joints with hardly a channel",
                "channels for the joints");
  }
  // The frames of limits_.longest_s.
  std::uint64_t FramesWanted() const {
    constexpr double kAll = 1e15;
    return static_cast<std::uint64_t>(std::min(limits_.longest_s * clip_.rate_hz + 1e-6, kAll)) + 1;
  }

  // All that there are: Frames: may be wrong.
  bool Rows(std::uint64_t frames) {
    const rig::RigPose rest(clip_.skeleton);
    for (std::uint64_t frame = 0;; ++frame) {
      if (frame % kRowsPerCheck == 0 && limits_.work.exceeded()) {
        return Refuse(limits_.work.Refusal(name_).message());
      }
      const std::string_view word = scan_.Word();
      if (word.empty()) {
        if (frame == 0) return Fail("no rows", "at least one");
        if (frame != frames) {
          Remark(std::to_string(frame) + " rows where Frames: says " + std::to_string(frames));
        }
        return true;
      }
      if (frame == FramesWanted()) {
        Remark(OnlyBegin(limits_.longest_s));
        return true;
      }
      if (!FramesFit(frame + 1)) return false;
      clip_.frames.push_back(rest);
      if (!Row(word, frame)) return false;
      if (frame > 0) KeepSigns(clip_.frames[frame - 1], clip_.frames[frame]);
    }
  }

  bool Row(std::string_view word, std::uint64_t frame) {
    rig::RigPose& pose = clip_.frames.back();
    std::size_t read = 0;
    bool whole = true;
    const int line = scan_.line();
    for (std::size_t joint = 0; joint < clip_.channels.size(); ++joint) {
      Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
      for (char kind : clip_.channels[joint]) {
        if (word.empty() && !Wrapped(frame, read, word)) {
          return FailIn(line, std::to_string(read) + " values in row " + std::to_string(frame + 1),
                        std::to_string(channel_count_));
        }
        double value = 0;
        if (IsNoNumber(word)) {
          whole = false;
        } else if (!Number(word, value)) {
          return Fail(Quote(word) + " as value " + std::to_string(read + 1) + " of row " +
                          std::to_string(frame + 1),
                      kNumber);
        }
        if (kind <= 'Z') {
          pose.translations[joint][kind - 'X'] = static_cast<float>(value);
        } else {
          // Angles repeat after 360 degrees, half-angle rotations after 720.
          const double within = std::abs(value) <= 360 ? value : std::remainder(value, 720.0);
          const double half = within * (std::numbers::pi / 360.0);
          Eigen::Quaterniond turn(std::cos(half), 0, 0, 0);
          turn.vec()[kind - 'x'] = std::sin(half);
          rotation = rotation * turn;
        }
        ++read;
        word = scan_.WordOnLine();
      }
      pose.rotations[joint] = rotation.cast<float>().normalized();
    }
    if (!word.empty()) {
      return Fail("more than " + std::to_string(channel_count_) + " values in row " +
                      std::to_string(frame + 1),
                  std::to_string(channel_count_));
    }
    if (whole) {
      whole_ = std::min(whole_, frame);
    } else {
      ++broken_;
      if (frame > 0) pose = clip_.frames[frame - 1];
    }
    return true;
  }

  // Whether the row continues in the next line, of which `word` is then the first one. The first
  // row decides for all: its lines must together have the values of a row.
  bool Wrapped(std::uint64_t frame, std::size_t read, std::string_view& word) {
    if (frame == 0 && !wraps_) {
      Scanner ahead = scan_;
      std::size_t values = read;
      while (values < channel_count_ && !ahead.Word().empty()) {
        ++values;
        while (!ahead.WordOnLine().empty()) ++values;
      }
      wraps_ = values == channel_count_;
    }
    if (!wraps_) return false;
    Remark("rows of several lines");
    word = scan_.Word();
    return !word.empty();
  }

  // After the last row.
  bool Repair() {
    if (broken_ > 0) {
      if (whole_ >= clip_.frames.size()) return Fail("no row of numbers alone", "at least one");
      for (std::uint64_t frame = 0; frame < whole_; ++frame) {
        clip_.frames[frame] = clip_.frames[whole_];
      }
      Remark((broken_ == 1 ? "a row" : std::to_string(broken_) + " rows") +
             std::string(" with values that are no numbers: the frame before stands for it"));
    }
    KeepOneSkeleton();
    FindOffsets();
    return true;
  }

  // Of several skeletons the one with most joints: others are props.
  void KeepOneSkeleton() {
    const rig::Skeleton& all = clip_.skeleton;
    std::vector<int> root(all.names.size()), joints(all.names.size());
    for (std::size_t j = 0; j < root.size(); ++j) {
      const int parent = all.parents[j];
      root[j] = parent < 0 ? static_cast<int>(j) : root[static_cast<std::size_t>(parent)];
      ++joints[static_cast<std::size_t>(root[j])];
    }
    const auto kept =
        static_cast<int>(std::max_element(joints.begin(), joints.end()) - joints.begin());
    if (joints[static_cast<std::size_t>(kept)] == all.joint_count()) return;
    std::string others;
    int count = 0;
    for (std::size_t j = 0; j < root.size(); ++j) {
      if (all.parents[j] >= 0 || static_cast<int>(j) == kept) continue;
      if (++count <= kOthersShown) others += " " + Quote(all.names[j]);
    }
    if (count > kOthersShown) others += " and " + std::to_string(count - kOthersShown) + " more";
    Remark("of several skeletons that of " + Quote(all.names[static_cast<std::size_t>(kept)]) +
           ", without" + others);
    const auto keep = [&](auto& list) {
      std::size_t to = 0;
      for (std::size_t j = 0; j < root.size(); ++j) {
        if (root[j] == kept) list[to++] = list[j];
      }
      list.resize(to);
    };
    for (rig::RigPose& frame : clip_.frames) {
      keep(frame.translations);
      keep(frame.rotations);
    }
    std::vector<int>& parents = clip_.skeleton.parents;
    for (int& parent : parents) parent = parent < 0 ? parent : parent - kept;
    keep(clip_.channels);
    keep(clip_.end_sites);
    keep(clip_.skeleton.names);
    keep(clip_.skeleton.offsets);
    keep(parents);
  }

  // Bones that are in the position channels alone have their lengths in the first frame.
  void FindOffsets() {
    rig::Skeleton& skeleton = clip_.skeleton;
    for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
      if (skeleton.parents[j] < 0) continue;
      const auto has = [&](char kind) { return clip_.channels[j].find(kind) != std::string::npos; };
      if (!skeleton.offsets[j].isZero() || !has('X') || !has('Y') || !has('Z')) return;
    }
    if (skeleton.names.size() < 2) return;
    for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
      if (skeleton.parents[j] >= 0) skeleton.offsets[j] = clip_.frames.front().translations[j];
    }
    Remark("no OFFSETs: the first frame's positions stand for them");
  }

  // q and -q are the same rotation: choose the sign that continues the previous frame.
  static void KeepSigns(const rig::RigPose& previous, rig::RigPose& pose) {
    for (std::size_t joint = 0; joint < pose.rotations.size(); ++joint) {
      Quat& q = pose.rotations[joint];
      if (q.dot(previous.rotations[joint]) < 0) q.coeffs() = -q.coeffs();
    }
  }

  Scanner scan_;
  const std::string& name_;
  const ReadLimits& limits_;
  std::size_t size_;
  std::size_t channel_count_ = 0;
  bool wraps_ = false;  // rows are of several lines
  // Rows with values that are no numbers, and the first row without.
  std::uint64_t broken_ = 0, whole_ = std::numeric_limits<std::uint64_t>::max();
  Clip clip_;
  std::string error_;
};

}  // namespace

std::string OnlyBegin(double seconds) {
  return "only its first " + NumberText(seconds) + " s are read";
}

Result<Clip> ParseBvh(std::string_view text, const std::string& name, const ReadLimits& limits) {
  if (text.starts_with("glTF")) {
    return Status::Error(name + ": found glTF, expected BVH");
  }
  std::string utf8;
  return Parser(PlainText(text, utf8), name, limits).Run();
}

Result<Clip> ReadBvh(const std::filesystem::path& file, const ReadLimits& limits) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"),
                                                               &std::fclose);
  if (!stream)
    return Status::Error(file.string() + ": found no readable file, expected a BVH file");
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  constexpr std::size_t kMaxSize = std::size_t{1} << 31;
  std::string text;
  for (std::size_t got = kBlock; got == kBlock;) {
    if (text.size() > kMaxSize) {
      return Status::Error(file.string() + ": found more than 2 GiB, expected a BVH file");
    }
    const std::size_t size = text.size();
    text.resize(size + kBlock);
    got = std::fread(text.data() + size, 1, kBlock, stream.get());
    text.resize(size + got);
  }
  if (std::ferror(stream.get()) != 0) {
    return Status::Error(file.string() + ": found a file that cannot be read, expected a BVH file");
  }
  return ParseBvh(text, file.string(), limits);
}

}  // namespace styled::clip
