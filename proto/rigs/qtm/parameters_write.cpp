// The XML of a server, for the stand-in.
#include <pugixml.hpp>
#include <sstream>

#include "proto/rigs/qtm/parameters.h"

namespace styled::qtm {
namespace {

using pugi::xml_node;

std::string Number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6f", value);
  return text.data();
}

template <std::size_t N>
void AppendNumbers(xml_node parent, const char* element, const char (&names)[N],
                   const std::array<double, N - 1>& values) {
  xml_node node = parent.append_child(element);
  for (std::size_t i = 0; i + 1 < N; ++i) {
    const char name[] = {names[i], '\0'};
    node.append_attribute(name) = Number(values[i]).c_str();
  }
}

void AppendTransform(xml_node parent, const SegmentDescription& segment) {
  AppendNumbers(parent, "Position", "XYZ", segment.position_mm);
  AppendNumbers(parent, "Rotation", "XYZW", segment.rotation);
}

void AppendFlat(xml_node parent, const SkeletonDescription& skeleton) {
  for (const SegmentDescription& segment : skeleton.segments) {
    xml_node node = parent.append_child("Segment");
    node.append_attribute("Name") = segment.name.c_str();
    node.append_attribute("ID") = segment.id;
    if (segment.parent >= 0) {
      node.append_attribute("Parent_ID") =
          skeleton.segments[static_cast<std::size_t>(segment.parent)].id;
    }
    AppendTransform(node, segment);
  }
}

void AppendNested(xml_node parent, const SkeletonDescription& skeleton) {
  parent.append_child("Scale").text() = "1.000000";
  std::vector<xml_node> nodes;
  const xml_node holder = parent.append_child("Segments");
  for (const SegmentDescription& segment : skeleton.segments) {
    const xml_node above =
        segment.parent < 0 ? holder : nodes[static_cast<std::size_t>(segment.parent)];
    xml_node node = xml_node(above).append_child("Segment");
    node.append_attribute("Name") = segment.name.c_str();
    node.append_attribute("ID") = segment.id;
    node.append_child("Solver").text() = "Global Optimization";
    // Where the segment was when it was defined, which is not the T-pose.
    SegmentDescription defined = segment;
    defined.rotation = {1, 0, 0, 0};
    AppendTransform(node.append_child("Transform"), defined);
    AppendTransform(node.append_child("DefaultTransform"), segment);
    for (const char* empty : {"DegreesOfFreedom", "Markers", "RigidBodies"}) {
      node.append_child(empty);
    }
    AppendNumbers(node, "Endpoint", "XYZ", {0, 0, 100});
    nodes.push_back(node);
  }
}

}  // namespace

std::string WriteParameters(const Parameters& parameters, int minor) {
  pugi::xml_document document;
  xml_node root = document.append_child(("QTM_Parameters_Ver_1." + std::to_string(minor)).c_str());
  if (parameters.frequency_hz) {
    xml_node general = root.append_child("General");
    general.append_child("Frequency").text() = Number(*parameters.frequency_hz).c_str();
  }
  if (parameters.up) {
    xml_node space = root.append_child("The_3D");
    space.append_child("AxisUpwards").text() = std::string(Name(*parameters.up)).c_str();
    space.append_child("Labels").text() = static_cast<unsigned>(parameters.labels.size());
    for (const std::string& label : parameters.labels) {
      space.append_child("Label").append_child("Name").text() = label.c_str();
    }
  }
  if (parameters.skeletons) {
    xml_node skeletons = root.append_child("Skeletons");
    for (const SkeletonDescription& skeleton : *parameters.skeletons) {
      xml_node node = skeletons.append_child("Skeleton");
      node.append_attribute("Name") = skeleton.name.c_str();
      minor >= kNestedMinor ? AppendNested(node, skeleton) : AppendFlat(node, skeleton);
    }
  }
  std::ostringstream text;
  document.save(text, "  ", pugi::format_indent | pugi::format_no_declaration);
  return text.str();
}

}  // namespace styled::qtm
