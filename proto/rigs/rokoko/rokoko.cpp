#include "proto/rigs/rokoko/rokoko.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "proto/rigs/result_name.h"
#include "proto/rigs/rokoko/json_reader.h"

namespace styled::rokoko {
namespace {

using R = DecodeResult;
using Type = JsonReader::Type;
using Value = JsonReader::Value;

constexpr double kMaxTime_s = 1e10;
constexpr float kPercent = 100;  // Studio's weights of expressions

// Reads the members of a frame. Each function reads the given value and returns false if reading
// must stop; the reason is the reader's error, or `fault_`.
class FrameReader {
 public:
  FrameReader(JsonReader& json, Frame& frame) noexcept : json_(json), frame_(frame) {}

  // Reads the first `size` bytes of the reader's buffer.
  R Read(std::size_t size) noexcept {
    frame_.version = 3;
    frame_.fps = 0;
    ClearScene();
    if (json_.Text(size, [this](std::string_view key, Value& value) {
          return JsonReader::Is(value, Type::null) ? json_.Skip(value) : ReadTop(key, value);
        })) {
      return has_actors_ && has_time_ ? R::kOk : R::kMissing;
    }
    if (fault_ != R::kOk) return fault_;
    switch (json_.error()) {
      case JsonReader::Error::kTooDeep:
        return R::kTooDeep;
      case JsonReader::Error::kOther:
        return R::kBadValue;
      default:
        return R::kBadJson;
    }
  }

 private:
  bool Fault(R fault) noexcept {
    fault_ = fault;
    return false;
  }

  void ClearScene() noexcept {
    frame_.time_s = 0;
    has_time_ = has_actors_ = false;
    frame_.actor_count = frame_.actors_left_out = 0;
    frame_.prop_count = frame_.props_left_out = 0;
  }

  // Calls `read(key, value)` per member; skips members that are null.
  template <typename ReadMember>
  bool Members(Value& object, const ReadMember& read) noexcept {
    return json_.Members(object, [this, &read](std::string_view key, Value& value) {
      return JsonReader::Is(value, Type::null) ? json_.Skip(value) : read(key, value);
    });
  }

  bool ReadTop(std::string_view key, Value& value) noexcept {
    if (key == "version") return ReadVersion(value);
    if (key == "fps") return ReadFloat(value, frame_.fps);
    if (key != "scene") return ReadSceneMember(key, value);  // layout 2
    ClearScene();
    return Members(value, [this](std::string_view inner, Value& member) {
      return ReadSceneMember(inner, member);
    });
  }

  bool ReadSceneMember(std::string_view key, Value& value) noexcept {
    if (key == "timestamp") return ReadTime(value);
    if (key == "actors") return ReadActors(value);
    if (key == "props") return ReadProps(value);
    return json_.Skip(value);
  }

  bool ReadFloat(Value& value, float& out) noexcept {
    double number = 0;
    if (!json_.Number(value, number)) return false;
    if (std::abs(number) > double{std::numeric_limits<float>::max()}) return Fault(R::kBadValue);
    out = static_cast<float>(number);
    return true;
  }

  bool ReadTime(Value& value) noexcept {
    if (!json_.Number(value, frame_.time_s)) return false;
    has_time_ = true;
    return (frame_.time_s >= 0 && frame_.time_s <= kMaxTime_s) || Fault(R::kBadValue);
  }

  // The version as 3, 2.5, "3.0" or "3,0".
  bool ReadVersion(Value& value) noexcept {
    if (!JsonReader::Is(value, Type::string)) {
      if (!ReadFloat(value, frame_.version)) return false;
    } else {
      std::array<char, 8> text{};
      std::size_t size = 0;
      if (!json_.String(value, text, size)) return false;
      std::replace(text.begin(), text.end(), ',', '.');
      const auto [end, error] = std::from_chars(text.data(), text.data() + size, frame_.version);
      if (error != std::errc()) return Fault(R::kBadVersion);
    }
    return (frame_.version >= 2 && frame_.version < 4) || Fault(R::kBadVersion);
  }

  bool ReadActors(Value& actors) noexcept {
    frame_.actor_count = frame_.actors_left_out = 0;
    has_actors_ = true;
    return json_.Elements(actors, [this](Value& value) {
      if (frame_.actor_count == kMaxActors) {
        ++frame_.actors_left_out;
        return json_.Skip(value);
      }
      const auto index = static_cast<std::size_t>(frame_.actor_count);
      if (!ReadActor(value, frame_.actors[index])) return false;
      ++frame_.actor_count;
      return true;
    });
  }

  bool ReadActor(Value& value, Actor& actor) noexcept {
    actor.name_size = 0;
    actor.hip_height_m = actor.total_height_m = 0;
    actor.has.reset();
    actor.has_face = false;
    joint_hint_ = 0;
    return Members(value, [&](std::string_view key, Value& member) {
      if (key == "name") return json_.String(member, actor.name_bytes, actor.name_size);
      if (key == "hipHeight") return ReadFloat(member, actor.hip_height_m);  // layout 2
      if (key == "dimensions") return ReadDimensions(member, actor);
      if (key == "face") return ReadFace(member, actor);
      if (key == "body") {
        actor.has.reset();
        return Members(member, [&](std::string_view name, Value& joint) {
          return ReadJoint(name, joint, actor);
        });
      }
      return ReadJoint(key, member, actor);  // layout 2
    });
  }

  bool ReadProps(Value& props) noexcept {
    frame_.prop_count = frame_.props_left_out = 0;
    if (!JsonReader::Is(props, Type::array)) return json_.Skip(props);
    return json_.Elements(props, [this](Value& value) {
      if (frame_.prop_count == kMaxProps || !JsonReader::Is(value, Type::object)) {
        ++frame_.props_left_out;
        return json_.Skip(value);
      }
      bool whole = false;
      if (!ReadProp(value, frame_.props[static_cast<std::size_t>(frame_.prop_count)], whole)) {
        return false;
      }
      ++(whole ? frame_.prop_count : frame_.props_left_out);
      return true;
    });
  }

  bool ReadProp(Value& value, Prop& prop, bool& whole) noexcept {
    prop.name_size = 0;
    bool has_position = false, has_rotation = false;
    const bool good = Members(value, [&](std::string_view key, Value& member) {
      if (key == "name" && JsonReader::Is(member, Type::string)) {
        return json_.String(member, prop.name_bytes, prop.name_size);
      }
      if (!JsonReader::Is(member, Type::object)) return json_.Skip(member);
      if (key == "position") return ReadAny(member, prop.pose.position_m, "xyz", has_position);
      if (key == "rotation") return ReadAny(member, prop.pose.rotation, "xyzw", has_rotation);
      return json_.Skip(member);
    });
    whole = has_position && has_rotation;
    return good;
  }

  bool ReadDimensions(Value& dimensions, Actor& actor) noexcept {
    return Members(dimensions, [&](std::string_view key, Value& value) {
      if (key == "hipHeight") return ReadFloat(value, actor.hip_height_m);
      if (key == "totalHeight") return ReadFloat(value, actor.total_height_m);
      return json_.Skip(value);
    });
  }

  bool ReadFace(Value& face, Actor& actor) noexcept {
    actor.face.fill(0);
    actor.has_face = false;
    if (!JsonReader::Is(face, Type::object)) return json_.Skip(face);
    return Members(face, [&](std::string_view key, Value& value) {
      const auto shape = arkit::Find(key);
      if (!shape || !JsonReader::Is(value, Type::number)) return json_.Skip(value);
      float percent = 0;
      if (!ReadFloat(value, percent)) return false;
      actor.face[*shape] = percent / kPercent;
      actor.has_face = true;
      return true;
    });
  }

  bool ReadJoint(std::string_view name, Value& value, Actor& actor) noexcept {
    const int joint = FindJoint(name, joint_hint_);
    if (joint < 0 || !JsonReader::Is(value, Type::object)) return json_.Skip(value);
    joint_hint_ = joint + 1;
    const auto index = static_cast<std::size_t>(joint);
    JointPose& pose = actor.joints[index];
    bool has_position = false, has_rotation = false;
    const bool good = Members(value, [&](std::string_view key, Value& member) {
      if (key == "position") return ReadNumbers(member, pose.position_m, "xyz", has_position);
      if (key == "rotation") return ReadNumbers(member, pose.rotation, "xyzw", has_rotation);
      return json_.Skip(member);
    });
    actor.has.set(index, has_position && has_rotation);
    return good;
  }

  // Reads an object of numbers, each under one letter, by `read`. Sets `all` if none is missing.
  template <std::size_t kCount, typename Read>
  bool ReadLetters(Value& object, std::array<float, kCount>& values, std::string_view letters,
                   bool& all, const Read& read) noexcept {
    std::bitset<kCount> found;
    const bool good = Members(object, [&](std::string_view key, Value& value) {
      const std::size_t at = key.size() == 1 ? letters.find(key) : std::string_view::npos;
      if (at == std::string_view::npos) return json_.Skip(value);
      found.set(at);
      return read(value, values[at]);
    });
    all = found.all();
    return good;
  }

  template <std::size_t kCount>
  bool ReadNumbers(Value& object, std::array<float, kCount>& values, std::string_view letters,
                   bool& all) noexcept {
    return ReadLetters(object, values, letters, all,
                       [this](Value& value, float& out) { return ReadFloat(value, out); });
  }

  // The same, but a value that is not a float reads as NaN.
  template <std::size_t kCount>
  bool ReadAny(Value& object, std::array<float, kCount>& values, std::string_view letters,
               bool& all) noexcept {
    return ReadLetters(object, values, letters, all, [this](Value& value, float& out) {
      out = std::numeric_limits<float>::quiet_NaN();
      double number = 0;
      if (!JsonReader::Is(value, Type::number)) return json_.Skip(value);
      if (!json_.Number(value, number)) return false;
      const bool fits = std::abs(number) <= double{std::numeric_limits<float>::max()};
      if (fits) out = static_cast<float>(number);
      return true;
    });
  }

  JsonReader& json_;
  Frame& frame_;
  R fault_ = R::kOk;
  bool has_time_ = false, has_actors_ = false;
  int joint_hint_ = 0;
};

// Writes text until a part does not fit.
class TextWriter {
 public:
  explicit TextWriter(std::span<char> out) noexcept : out_(out) {}

  // 0 if something did not fit or a number was not finite.
  std::size_t size() const noexcept { return good_ ? size_ : 0; }

  TextWriter& operator<<(std::string_view text) noexcept {
    good_ = good_ && text.size() <= out_.size() - size_;
    if (!good_) return *this;
    std::copy(text.begin(), text.end(), out_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += text.size();
    return *this;
  }
  template <typename T>
    requires std::is_floating_point_v<T>
  TextWriter& operator<<(T value) noexcept {
    good_ = good_ && std::isfinite(value);
    if (!good_) return *this;
    const auto [end, error] = std::to_chars(out_.data() + size_, out_.data() + out_.size(), value);
    good_ = error == std::errc();
    if (good_) size_ = static_cast<std::size_t>(end - out_.data());
    return *this;
  }
  // Writes the text in quotes.
  void Quoted(std::string_view text) noexcept {
    *this << "\"";
    for (const char& c : text) {
      if (c == '"' || c == '\\') {
        *this << "\\" << std::string_view(&c, 1);
      } else if (static_cast<unsigned char>(c) < 0x20) {
        constexpr std::string_view kHex = "0123456789abcdef";
        const auto code = static_cast<unsigned char>(c);
        *this << "\\u00" << kHex.substr(code >> 4U, 1) << kHex.substr(code & 0xFU, 1);
      } else {
        *this << std::string_view(&c, 1);
      }
    }
    *this << "\"";
  }

 private:
  std::span<char> out_;
  std::size_t size_ = 0;
  bool good_ = true;
};

void WritePose(const JointPose& pose, TextWriter& out) noexcept {
  const auto& [p, r] = pose;
  out << "\"position\":{\"x\":" << p[0] << ",\"y\":" << p[1] << ",\"z\":" << p[2]
      << "},\"rotation\":{\"x\":" << r[0] << ",\"y\":" << r[1] << ",\"z\":" << r[2]
      << ",\"w\":" << r[3] << "}";
}

void WriteActor(const Actor& actor, TextWriter& out) noexcept {
  bool left = true, right = true;
  for (std::size_t k = 0; k < kFingerJoints; ++k) {
    left = left && actor.has[kBodyJoints + k];
    right = right && actor.has[kBodyJoints + kFingerJoints + k];
  }
  const auto word = [](bool value) { return value ? "true" : "false"; };
  out << "{\"name\":";
  out.Quoted(actor.name());
  out << ",\"color\":[255,255,255],\"meta\":{\"hasGloves\":" << word(left || right)
      << ",\"hasLeftGlove\":" << word(left) << ",\"hasRightGlove\":" << word(right)
      << ",\"hasBody\":true,\"hasFace\":" << word(actor.has_face)
      << "},\"dimensions\":{\"totalHeight\":" << actor.total_height_m
      << ",\"hipHeight\":" << actor.hip_height_m << "},\"body\":{";
  std::string_view separator = "\"";
  for (std::size_t j = 0; j < kJoints; ++j) {
    if (!actor.has[j]) continue;
    out << separator << kJointTable[j].name << "\":{";
    WritePose(actor.joints[j], out);
    out << "}";
    separator = ",\"";
  }
  out << "},\"face\":{\"faceId\":\"\"";
  for (std::size_t i = 0; actor.has_face && i < arkit::kShapes; ++i) {
    out << ",\"" << arkit::kNames[i] << "\":" << kPercent * actor.face[i];
  }
  out << "}}";
}

}  // namespace

void Named::set_name(std::string_view name) noexcept {
  name_size = std::min(name.size(), kMaxNameSize);
  // Do not cut within a character.
  while (name_size < name.size() && name_size > 0 &&
         (static_cast<unsigned char>(name[name_size]) & 0xC0U) == 0x80) {
    --name_size;
  }
  std::copy_n(name.begin(), name_size, name_bytes.begin());
}

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(result, {"ok", "not_rokoko", "bad_lz4", "too_long", "bad_json",
                                   "too_deep", "bad_version", "bad_value", "missing"});
}

Decoder::Decoder() : json_(std::make_unique<JsonReader>(kMaxTextSize)) {}
Decoder::~Decoder() = default;

DecodeResult Decoder::DecodeText(std::string_view text, Frame& frame) noexcept {
  if (text.size() > kMaxTextSize) return R::kTooLong;
  std::copy(text.begin(), text.end(), json_->buffer().begin());
  return FrameReader(*json_, frame).Read(text.size());
}

DecodeResult Decoder::Decode(std::span<const std::byte> bytes, Frame& frame) noexcept {
  if (IsLz4Frame(bytes)) {
    std::size_t size = 0;
    switch (unpacker_.Unpack(bytes, std::as_writable_bytes(json_->buffer()), size)) {
      case Lz4Unpacker::Result::kBad:
        return R::kBadLz4;
      case Lz4Unpacker::Result::kTooLong:
        return R::kTooLong;
      case Lz4Unpacker::Result::kOk:
        return FrameReader(*json_, frame).Read(size);
    }
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || text[first] != '{') return R::kNotRokoko;
  return DecodeText(text, frame);
}

std::size_t EncodeText(const Frame& frame, std::span<char> out) noexcept {
  TextWriter writer(out);
  writer << "{\"version\":\"3,0\",\"fps\":" << frame.fps
         << ",\"scene\":{\"timestamp\":" << frame.time_s << ",\"actors\":[";
  for (std::size_t k = 0; k < static_cast<std::size_t>(frame.actor_count); ++k) {
    if (k > 0) writer << ",";
    WriteActor(frame.actors[k], writer);
  }
  writer << "],\"props\":[";
  for (std::size_t k = 0; k < static_cast<std::size_t>(frame.prop_count); ++k) {
    writer << (k > 0 ? ",{\"name\":" : "{\"name\":");
    writer.Quoted(frame.props[k].name());
    writer << ",\"color\":[255,255,255],\"type\":0,";
    WritePose(frame.props[k].pose, writer);
    writer << "}";
  }
  writer << "]}}";
  return writer.size();
}

}  // namespace styled::rokoko
