#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "model/rig/dialects.h"
#include "model/rig/grip.h"
#include "model/stylist/settings.h"
#include "proto/styled/v1/look.pb.h"

// The whole configuration as one struct. The manual is styled.toml beside this file: it gives unit,
// range and reason of each key. The values here are the defaults.
namespace styled::config {

// Assigns a tracker without a skeleton of its own to a body part.
struct Tracker {
  std::string id;    // as the rig names it, e.g. a MAC address
  std::string part;  // a joint of the canonical humanoid
  friend bool operator==(const Tracker&, const Tracker&) = default;
};

// The One Euro filter on a source's poses (perform/performer/smoothing.h).
struct Smoothing {
  float rest_hz = 0;       // cutoff at rest, Hz; 0: no filter
  float per_speed = 0.7F;  // how much the cutoff grows, Hz per rad/s of a joint
  friend bool operator==(const Smoothing&, const Smoothing&) = default;
};

// The words of Source::parts; "fingers": those of both hands.
inline constexpr std::array<std::string_view, 4> kMergedParts{"face", "fingers", "leftFingers",
                                                              "rightFingers"};
// The hand that holds one of a source's props, by the prop's name.
using PropHands = std::map<std::string, rig::Hand, std::less<>>;

struct Source {
  std::string name = "rig";    // [A-Za-z0-9_-]{1,32}; performers are called NAME.PERFORMER
  std::string type = "udp";    // rigs::kSourceTypes (proto/rigs/types.h)
  std::string listen;          // HOST:PORT; "" = the type's default port, on every interface
  std::string performer = {};  // for rigs that do not name their performers; "" = the source's name
  // The rig's vertical axis, for rigs that have a switch for it: "auto", "y" or "z".
  std::string up = "auto";
  // OptiTrack's server, its multicast group, and the network interface that receives it.
  std::string server = {}, group = "239.255.42.99", interface = {};
  bool multicast = true;
  std::string coordinates = "auto";  // bones relative to "global", "local" or as "auto" detects
  std::vector<Tracker> trackers = {};
  rig::JointNames joints = {};  // joint names set by hand, for rigs whose names are not recognized
  float rate_hz = 100;          // rate of frames assembled from trackers, which have no common
                                // clock
  float delay_s = 0;            // delay of the frames, so that bursts leave evenly; 0 = none
  int receive_buffer_bytes = 4 << 20;
  int max_connections = 64;  // tcp
  std::string usb_id = {};   // "1209:7690"; "" = any SlimeVR receiver (type usb requires an id)
  std::string serial = {};   // serial number of the one USB device to open; "" = all
  Smoothing smoothing = {};
  // The performer, SOURCE.NAME, that gets the parts of this source; "" = the source has performers
  // of its own; kOnlyPerformer: the one who is alone here.
  std::string merge_into = {};
  // Some of kMergedParts; empty: the face.
  std::vector<std::string> parts = {};
  // For a source of a face alone: "standing" or "seated", its performer's body, whose head and eyes
  // follow the face; "none": the face goes to a performer of another source; "auto": none if
  // another source has performers, else standing.
  std::string body = "auto";
  std::string expressions = "arkit";  // names that are sent: "arkit", or "vrm" for VRM's presets
  PropHands props = {};               // props without an entry: rig::Hand::kAuto
  int sender_limit_hz = 100000;       // most datagrams a second of one address; 0 = no limit
  friend bool operator==(const Source&, const Source&) = default;

  // Whether the source's performers have nothing but a face, and a body of our own (face_body.h).
  bool FaceAlone() const { return body == "standing" || body == "seated"; }
  // Whether `part`, "face", "leftFingers" or "rightFingers", is merged; false without merge_into.
  bool Merges(std::string_view part) const;
};

inline constexpr std::string_view kOnlyPerformer = "*";  // of Source::merge_into

// An additional skeleton onto which the styled motion is retargeted and published.
struct Output {
  std::string name;                     // the topic: styled/<performer>/<name>/
  std::string avatar;                   // file: .vrm, .glb, .gltf or .bvh
  std::string dialect = "auto";         // dialect of a BVH file
  rig::JointNames joints;               // joint names set by hand
  std::vector<std::string> performers;  // ids; empty = all
  std::string place;                    // file:line, for errors
};

// Which users may connect to an ipc:// address.
struct Ipc {
  int mode = 0600;  // mode of the socket's file; connecting requires the right to write
  std::vector<std::string> users;  // names or numbers; empty: all users that `mode` permits
  friend bool operator==(const Ipc&, const Ipc&) = default;
};

inline constexpr int kMostHighWaterMark = 100'000;

struct Publish {
  std::string address = "tcp://127.0.0.1:7001";
  bool allow_unauthenticated_remote = false;
  Ipc ipc;
  int high_water_mark = 64;  // messages, 1 to kMostHighWaterMark
  int send_buffer_bytes = 65536;
  int max_subscriptions = 1024;
  bool canary = true;
  friend bool operator==(const Publish&, const Publish&) = default;
};

struct Control {
  std::string address = "tcp://127.0.0.1:7002";
  bool allow_unauthenticated_remote = false;
  Ipc ipc;
  friend bool operator==(const Control&, const Control&) = default;
};

// Keys of clients on other machines: daemon/security/README.md.
struct Security {
  std::string keys;  // folder; "" = no keys
  friend bool operator==(const Security&, const Security&) = default;
};

struct Model {
  std::string weights;  // "" = the shipped weights
  // File of a second network that makes styles from examples; "" = the shipped one with the shipped
  // weights, none with others. "none": none.
  std::string examples;
  // File of a network that follows gaits: its styles, and those of examples that walk or run; "":
  // the shipped one with the shipped weights and with others that have no space of styles. "none":
  // none.
  std::string gaits;
  std::string precision = "int8";  // one of net::kPrecisions
  stylist::Options stylist;
};

struct Performers {
  int max_performers = 64;
  float stale_s = 0.25F;
  float forget_s = 60.0F;
  float takeover_s = 0.1F;
  float clock_back_s = 1.0F;
  float late_s = 0.025F;
  float backlog_s = 0.1F;
};

struct Style {
  std::string initial;  // a preset or a style; "" = bypass
  std::string library;  // differences from InitialLook(); no mix
  v1::Look look;        // what else differs from InitialLook(); no mix
};

struct Preset {
  std::string name;
  v1::Look look;      // a mix of styles or aliases
  std::string place;  // file:line, for errors
};

// A prepared change of style, fired by its name or by the performers' timecode.
struct Cue {
  std::string name;
  std::string at;               // "HH:MM:SS:FF"; "" = by name only
  std::string performer = "*";  // an id, or "*"
  std::string style;            // alone, at weight 1; excludes look.mix, .preset and .clear
  bool panic = false;
  v1::Look look;      // the fields that change
  std::string place;  // file:line, for errors
};

// Open Sound Control, for consoles and control surfaces.
struct Osc {
  std::string listen;  // HOST:PORT; "" = off
  bool allow_unauthenticated_remote = false;
  friend bool operator==(const Osc&, const Osc&) = default;
};

// Two daemons, each of which can take over from the other.
struct Standby {
  std::string peer;                              // the other daemon's `address`; "" = none
  std::string peer_key;                          // its public key, Z85; "" = none
  std::string address = "tcp://127.0.0.1:7004";  // address of this daemon's journal
  bool allow_unauthenticated_remote = false;
  bool first = false;   // leads when both have just started
  float hold_s = 0.1F;  // silence of the leader after which the standby takes over
  friend bool operator==(const Standby&, const Standby&) = default;
};

struct Time {
  std::string ptp4l;  // ptp4l's management socket; "" = the usual path
  friend bool operator==(const Time&, const Time&) = default;
};

struct State {
  std::string dir;  // "" = settings are not kept
};

struct Record {
  std::string file;  // strftime pattern or folder; "" = nothing is recorded
  int min_free_mb = 256;
  friend bool operator==(const Record&, const Record&) = default;
};

struct Log {
  std::string level = "info";
};

struct Realtime {
  bool lock_memory = true;
  int priority = 0;
  int cpu = -1;
  std::string wait = "block";  // "hybrid", "busy"
  bool prewarm = true;
  bool relieve = true;
  int styling_threads = 1;  // the pipeline thread included
  friend bool operator==(const Realtime&, const Realtime&) = default;
};

struct Config {
  std::vector<Source> sources{{"rig", "udp", "127.0.0.1:7000"}, {"rig", "tcp", "127.0.0.1:7000"}};
  std::vector<Output> outputs;
  Publish publish;
  Control control;
  Security security;
  Model model;
  Performers performers;
  Style style;
  std::vector<Preset> presets;
  std::vector<Cue> cues;
  Osc osc;
  Standby standby;
  Time time;
  State state;
  Record record;
  Log log;
  Realtime realtime;
  // Where each key was set, for errors: "source.0.listen" was set at "stage.toml:12" or by
  // "STYLED_PUBLISH_ADDRESS". Keys with their default value are absent.
  std::map<std::string, std::string, std::less<>> places;
};

// The largest accepted file: the manual with all its comments has 13 KiB. The limit also bounds the
// time and memory of a reload during a show.
inline constexpr std::size_t kMaxFileBytes = 1 << 20;
// The most entries of each of [[source]], [[output]], [[cue]] and [presets]. Some checks compare
// every pair; with this many entries they take milliseconds.
inline constexpr std::size_t kMaxEntries = 4096;

// One setting from the command line ("section.key=value") or the environment.
struct Override {
  std::string key;    // "publish.address", "source.0.listen"
  std::string value;  // as TOML; text that is not valid TOML is used as a string
  std::string place;  // "--set publish.address" or "STYLED_PUBLISH_ADDRESS", for errors
};

// Reads STYLED_<SECTION>_<KEY> from `environment` ("NAME=value" strings, ended by null). A name
// with a known section must have a known key, otherwise the result is an error. Other names that
// begin with STYLED_ are ignored.
Result<std::vector<Override>> EnvironmentOverrides(const char* const* environment);
// Parses "section.key=value".
Result<Override> ParseOverride(const std::string& text);

// Applies the defaults, then `file` ("" = none), then `overrides` in order, then Validate. Errors
// name file, line, key, the expected value and, for an unknown key, the nearest known one. Any
// other content at the file's path (a pipe, a device, 100,000 nested tables, binary data) gives an
// error. Start-up and reload only; allocates; any thread.
Result<Config> Load(const std::string& file, const std::vector<Override>& overrides);
// The same for the text of a file; errors call it `name`.
Result<Config> Parse(const std::string& text, const std::string& name,
                     const std::vector<Override>& overrides);

// Checks the rules that span keys: at least one source, no address twice, only loopback addresses
// unless allowed, presets as the control socket would accept them. The style names are checked
// later, against the weights. Errors begin with the key.
Status Validate(const Config& config);

// Whether a socket at `address` requires keys: the address is not local, a folder of keys is
// configured, and unauthenticated clients are not allowed.
bool RequiresKeys(const Config& config, std::string_view address,
                  bool allow_unauthenticated_remote);

// IsName: the rule for names of performers and sources (WIRE.md). IsPerformerId: SOURCE.NAME, where
// both parts are such names.
bool IsName(std::string_view text) noexcept;
bool IsPerformerId(std::string_view text) noexcept;

}  // namespace styled::config
