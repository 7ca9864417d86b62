#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::support {

// A rig's stand-in (sim/rigs) and the real daemon, with real sockets between.
struct RigRun {
  std::string type;                 // of source and stand-in; "udp" or "tcp" is our own protocol
  std::string stand_in;             // where it has another name than the source's type
  std::vector<std::string> quirks;  // of the stand-in
  std::string keys;                 // further TOML lines of the source
  std::vector<std::string> performers{"sim"};
  std::string expected_performer;  // id of the first performer; "" = "suit." and its name
  double rate_hz = 60;
  int frames = 180;
  std::string faults;  // as of stylesim --faults
  // What each performer does: a BVH file from `clip_from_s` on, on Bandai's skeleton; "" = the
  // synthetic performer.
  std::filesystem::path clip;
  double clip_from_s = 0;
  std::string weights;       // file; "" = random ones
  std::string style;         // set, at once and whole, when ...
  int style_from_frame = 0;  // ... this frame has been sent
};

// What came out on the canonical topic, against the poses that the stand-in was given; as long as
// the style is off, they are to be the same.
struct RigResult {
  int sent = 0, received = 0;        // frames of the first performer
  int compared = 0;                  // of them, those before the style
  float worst_deg = 0, worst_m = 0;  // over all joints' local rotations, over the hips' position
  std::string where;                 // joint and frame of worst_deg
  std::vector<v1::Body> bodies;
  std::vector<v1::Frame> frames;                     // canonical, of the first performer
  std::vector<v1::Frame> rig_frames, source_frames;  // his own skeleton, styled and as captured
  std::vector<std::pair<std::string, std::uint64_t>> counters;
  std::string log;

  std::uint64_t Counter(const std::string& name) const;
};

// Plays the synthetic performer. Test failures where the daemon does not start or nothing comes.
RigResult StreamAsRig(const RigRun& run);

// Half a degree, half a centimetre, nothing refused, nothing held, and no more than `may_lack`
// frames missing.
void ExpectTheSameMotion(const RigResult& result, int may_lack = 0);

}  // namespace styled::support
