#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::support {

// A simulated rig (sim/rigs) and the real daemon, connected by real sockets.
struct RigRun {
  std::string type;      // of source and simulated rig; "udp" or "tcp" is the native protocol
  std::string stand_in;  // type of the simulated rig, if it differs from the source's
  std::vector<std::string> quirks;  // of the simulated rig
  std::string keys;                 // additional TOML lines of the source
  std::vector<std::string> performers{"sim"};
  std::string expected_performer;  // id of the first performer; "" = "suit." and its name
  double rate_hz = 60;
  int frames = 180;
  std::string faults;  // as for stylesim --faults
  // The performers' motion: a BVH file on Bandai's skeleton, starting at `clip_from_s`; "" = the
  // synthetic performer.
  std::filesystem::path clip;
  double clip_from_s = 0;
  std::string weights;       // file; "" = random ones
  std::string style;         // set without a fade when ...
  int style_from_frame = 0;  // ... this frame has been sent
};

// The frames on the canonical topic, compared with the poses given to the simulated rig. Without a
// style they must be the same.
struct RigResult {
  int sent = 0, received = 0;  // frames of the first performer
  // Frames whose sending took longer than a quarter of a period, because the machine ran something
  // else. A rig that fills many datagrams a frame and marks no end then seems to pause in one.
  int interrupted = 0;
  int compared = 0;                  // of `received`, those before the style was set
  float worst_deg = 0, worst_m = 0;  // over all joints' local rotations; over the hips' position
  std::string where;                 // joint and frame of worst_deg
  std::vector<v1::Body> bodies;
  std::vector<v1::Frame> frames;  // canonical, of the first performer
  // On the performer's own skeleton, styled and as captured.
  std::vector<v1::Frame> rig_frames, source_frames;
  std::vector<std::pair<std::string, std::uint64_t>> counters;
  std::string log;

  std::uint64_t Counter(const std::string& name) const;
};

// Plays the motion. The test fails if the daemon does not start or nothing arrives.
RigResult StreamAsRig(const RigRun& run);

// Expects at most half a degree and half a centimetre of error, no refused or held frames, and at
// most `may_lack` missing frames. Of frames that were interrupted, some may be held.
void ExpectTheSameMotion(const RigResult& result, int may_lack = 0);

}  // namespace styled::support
