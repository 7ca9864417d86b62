#include "proto/rigs/qtm/parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <pugixml.hpp>

namespace styled::qtm {
namespace {

using pugi::xml_node;

constexpr std::array<std::string_view, 6> kAxes{"+X", "+Y", "+Z", "-X", "-Y", "-Z"};

// Does not depend on the process's locale. Beyond 1e9 no length, rate or rotation makes sense.
template <typename T>
bool ReadNumber(std::string_view text, T& value) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return false;
  text = text.substr(first, text.find_last_not_of(" \t\r\n") + 1 - first);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() &&
         std::abs(static_cast<double>(value)) < 1e10;
}

// Reads the attributes called by `names`, one letter each; leaves the values of missing ones
// unchanged.
template <std::size_t N>
Status ReadAttributes(const xml_node& node, const char (&names)[N], std::string_view where,
                      std::array<double, N - 1>& values) {
  for (std::size_t i = 0; i + 1 < N; ++i) {
    const char name[] = {names[i], '\0'};
    const pugi::xml_attribute attribute = node.attribute(name);
    if (attribute.empty() || (ReadNumber(attribute.value(), values[i]) && std::isfinite(values[i])))
      continue;
    return Status::Error(std::string(where) + ": " + node.name() + " " + name + "=\"" +
                         ToString(attribute.value()) + "\", expected a number");
  }
  return Status::Ok();
}

Status ReadTransform(const xml_node& segment, std::string_view where, SegmentDescription& out) {
  xml_node holder = segment;
  for (const char* name : {"DefaultTransform", "Transform"}) {
    if (const xml_node found = segment.child(name)) {
      holder = found;
      break;
    }
  }
  Status status = ReadAttributes(holder.child("Position"), "XYZ", where, out.position_mm);
  if (!status.ok()) return status;
  return ReadAttributes(holder.child("Rotation"), "XYZW", where, out.rotation);
}

class SkeletonReader {
 public:
  explicit SkeletonReader(SkeletonDescription& out) : out_(out) {}

  Status Read(const xml_node& skeleton) {
    const xml_node nested = skeleton.child("Segments");
    out_.name = skeleton.attribute("Name").value();
    out_.global = !nested;
    return ReadSegments(nested ? nested : skeleton, -1, 0);
  }

 private:
  // Nested segments, their parents before them; or the list of the flat form.
  Status ReadSegments(const xml_node& holder, int parent, int depth) {
    if (depth > kMaxDepth) return Refuse("segments deeper than " + std::to_string(kMaxDepth));
    for (const xml_node& node : holder.children("Segment")) {
      // Only counted: looking for parents among an unlimited number would take quadratic time.
      if (out_.segments.size() == kMaxSegments) {
        ++out_.segments_left_out;
        if (Status status = ReadNested(node, parent, depth); !status.ok()) return status;
        continue;
      }
      SegmentDescription segment;
      segment.name = node.attribute("Name").value();
      segment.parent = parent;
      segment.id = static_cast<std::uint32_t>(out_.segments.size());
      const std::string where = "segment " + ToString(segment.name);
      if (const auto id = node.attribute("ID"); id && !ReadNumber(id.value(), segment.id)) {
        return Refuse(where + ": ID=\"" + ToString(id.value()) + "\", expected a number");
      }
      if (out_.global) {
        if (Status status = FindParent(node, where, segment); !status.ok()) return status;
      }
      if (Status status = ReadTransform(node, where, segment); !status.ok()) {
        return Refuse(status.message());
      }
      const auto index = static_cast<int>(out_.segments.size());
      out_.segments.push_back(std::move(segment));
      if (Status status = ReadNested(node, index, depth); !status.ok()) return status;
    }
    return Status::Ok();
  }
  Status ReadNested(const xml_node& segment, int index, int depth) {
    return out_.global ? Status::Ok() : ReadSegments(segment, index, depth + 1);
  }

  Status FindParent(const xml_node& node, const std::string& where, SegmentDescription& segment) {
    const auto text = node.attribute("Parent_ID");
    if (!text || std::string_view(text.value()).empty()) return Status::Ok();
    std::uint32_t id = 0;
    if (ReadNumber(text.value(), id)) {
      const auto found = std::ranges::find(out_.segments, id, &SegmentDescription::id);
      segment.parent = static_cast<int>(found - out_.segments.begin());
      if (found != out_.segments.end()) return Status::Ok();
    }
    return Refuse(where + ": Parent_ID=\"" + ToString(text.value()) +
                  "\", expected the ID of a segment before it");
  }

  Status Refuse(const std::string& what) const {
    return Status::Error("skeleton " + ToString(out_.name) + ": " + what);
  }

  SkeletonDescription& out_;
};

Status ReadRoot(const xml_node& root, Parameters& out) {
  if (const xml_node frequency = root.child("General").child("Frequency")) {
    double hz = 0;
    if (!ReadNumber(frequency.child_value(), hz) || !(hz > 0)) {
      return Status::Error("General: Frequency \"" + ToString(frequency.child_value()) +
                           "\", expected a number above 0");
    }
    out.frequency_hz = hz;
  }
  if (const xml_node up = root.child("The_3D").child("AxisUpwards")) {
    const auto found = std::ranges::find(kAxes, std::string_view(up.child_value()));
    if (found == kAxes.end()) {
      return Status::Error("The_3D: AxisUpwards \"" + ToString(up.child_value()) +
                           "\", expected one of +X, +Y, +Z, -X, -Y, -Z");
    }
    out.up = static_cast<Axis>(found - kAxes.begin());
  }
  const xml_node skeletons = root.child("Skeletons");
  if (!skeletons) return Status::Ok();
  out.skeletons.emplace();
  for (const xml_node& node : skeletons.children("Skeleton")) {
    SkeletonDescription& skeleton = out.skeletons->emplace_back();
    if (out.skeletons->size() > kMaxSkeletons) {
      skeleton.name = node.attribute("Name").value();
      continue;
    }
    Status status = SkeletonReader(skeleton).Read(node);
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

}  // namespace

std::string_view Name(Axis axis) noexcept { return kAxes[static_cast<std::size_t>(axis)]; }

Result<Parameters> ReadParameters(std::string_view xml) {
  // Checked before the text is parsed, so that memory is bounded. Each element begins with this
  // character, which has no other meaning in XML.
  if (static_cast<std::size_t>(std::ranges::count(xml, '<')) > 2 * kMaxElements) {
    return Status::Error("XML with more than " + std::to_string(kMaxElements) + " elements");
  }
  pugi::xml_document document;
  const auto parsed =
      document.load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    return Status::Error("not XML: byte " + std::to_string(parsed.offset) + ": " +
                         parsed.description());
  }
  Parameters out;
  if (Status status = ReadRoot(document.document_element(), out); !status.ok()) return status;
  return out;
}

}  // namespace styled::qtm
