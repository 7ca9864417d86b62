// Writes small BVH files, one per exporter's conventions, as seeds of bvh_fuzz.
#include <span>
#include <string>

#include "tests/fuzz/write_seeds.h"

namespace {

std::vector<std::byte> Bytes(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

int main(int argc, char** argv) {
  const std::string small =
      "HIERARCHY\nROOT Hips\n{\n  OFFSET 1 2 3\n"
      "  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
      "  JOINT Left Arm\n  {\n    OFFSET 0 10 0\n    CHANNELS 3 Zrotation Yrotation Xrotation\n"
      "    End Site\n    {\n      OFFSET 0 5 0\n    }\n  }\n}\n"
      "MOTION\nFrames: 2\nFrame Time: 0.0333333\n4 5 6 90 0 0 0 0 90\n7 8 9 0 0 0 10 20 30\n";
  std::string crlf;
  for (const char c : small) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  const std::string one =
      "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Yrotation\n}\n"
      "MOTION\nFrames: 3\nFrame Time: 0.01\n-180\n1e3\n.5\n";
  const std::string positions =
      "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\n"
      "JOINT b\n{\nOFFSET 1 0 0\n"
      "CHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation Zrotation\n}\n"
      "JOINT c\n{\nOFFSET -1 0 0\nCHANNELS 0\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n}\n"
      "MOTION\nFrames: 1\nFrame Time: 0.008333\n1 2 3 4 5 6 7 8 9\n";
  return styled::fuzz::WriteSeeds(argc, argv,
                                  {Bytes(small), Bytes(crlf), Bytes(one), Bytes(positions)});
}
