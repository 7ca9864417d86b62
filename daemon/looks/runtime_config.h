#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/looks/cues.h"
#include "daemon/looks/made_style.h"
#include "daemon/looks/retarget_output.h"
#include "model/base/status.h"
#include "model/net/stylizer.h"
#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"

namespace styled::pipeline {

// Everything that a reload may change: the configuration and the content of its files. The
// supervisor or the files thread makes it; it is immutable and shared with the pipeline thread.
struct RuntimeConfig {
  std::shared_ptr<const net::Stylizer> network;
  std::shared_ptr<const net::Stylizer> loaded;  // the same without styles that were added
  int own_styles = 0;  // of the weights files; those behind it were added (styles/style_list.h)
  int last_place = 0;  // of a style that was added
  MadeStyles made;     // the latter, by name, but those that are retired
  // What was in the places of retired styles, by number in the network: performers may still fade
  // out from it.
  std::map<int, std::shared_ptr<const MadeStyle>> retired;
  std::string weights_name;             // file names, for status
  std::uint32_t weights_crc = 0;        // of all their bytes
  std::string weights_hash;             // Networks::examples_hash
  std::set<std::string> kept;           // of `made`, those that the library has (styles/library.h)
  std::vector<std::string> complaints;  // what the library has and cannot be used, for the log
  config::Performers performers;
  config::Style style;
  std::vector<config::Preset> presets;
  std::vector<Cue> cues;
  stylist::Options stylist;
  std::vector<rig::JointNames> joints;       // joint names set by hand, per source
  std::vector<config::Smoothing> smoothing;  // per source
  std::vector<config::PropHands> props;      // per source
  std::vector<std::shared_ptr<const RetargetOutput>> outputs;  // as the [[output]] tables
};

}  // namespace styled::pipeline
