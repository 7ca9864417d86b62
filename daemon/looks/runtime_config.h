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
#include "model/net/licence.h"
#include "model/net/stylizer.h"
#include "model/rig/dialects.h"
#include "model/stylist/stylist.h"

namespace styled::pipeline {

// Everything that a reload may change: the configuration and the content of its files. The
// supervisor or the files thread makes it; it is immutable and shared with the pipeline thread.
struct RuntimeConfig {
  std::shared_ptr<const net::Stylizer> network;
  std::shared_ptr<const net::Stylizer> loaded;  // the network without added styles
  int own_styles = 0;  // the number of styles of the weights files; the styles after them were
                       // added (styles/style_list.h)
  int last_place = 0;  // the place of the style that was added last
  MadeStyles made;     // the added styles by name, without retired ones
  // The former codes in the places of retired styles, by number in the network: performers may
  // still be fading out from them.
  std::map<int, std::shared_ptr<const MadeStyle>> retired;
  std::string weights_name;             // file names, for status
  std::vector<net::Terms> terms;        // of each file of weights
  std::uint32_t weights_crc = 0;        // hash of all their bytes
  std::string weights_hash;             // Networks::examples_hash
  std::set<std::string> kept;           // those of `made` that are in the library
                                        // (styles/library.h)
  std::vector<std::string> complaints;  // files of the library that cannot be used, and why; for
                                        // the log
  config::Performers performers;
  config::Style style;
  std::vector<config::Preset> presets;
  std::vector<Cue> cues;
  stylist::Options stylist;
  std::vector<rig::JointNames> joints;       // joint names set by hand, per source
  std::vector<config::Smoothing> smoothing;  // per source
  std::vector<config::PropHands> props;      // per source
  std::vector<float> idle;  // per source: Look.idle of a performer seen for the first time
  std::vector<std::shared_ptr<const RetargetOutput>> outputs;  // in the order of the [[output]]
                                                               // tables
};

}  // namespace styled::pipeline
