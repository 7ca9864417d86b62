#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/rig/dialects.h"
#include "model/stylist/settings.h"

// All that can be configured, one struct; styled.toml beside this file is its manual and says for
// each key the unit, the range and the reason. Values here are the defaults.
namespace styled::config {

// Body part that a tracker without a skeleton of its own is worn on.
struct Tracker {
  std::string id;    // as the rig names it, e.g. a MAC address
  std::string part;  // a joint of the canonical humanoid
  friend bool operator==(const Tracker&, const Tracker&) = default;
};

struct Source {
  std::string name = "rig";    // [A-Za-z0-9_-]{1,32}
  std::string type = "udp";    // kSourceTypes
  std::string listen;          // HOST:PORT; "" = the type's usual port, on every interface
  std::string performer = {};  // of rigs that do not name theirs; "" = the source's name
  std::string up = "auto";     // the rig's vertical axis where it is a switch: "auto", "y" or "z"
  // OptiTrack's server, its stream and the network interface it comes in by.
  std::string server = {}, group = "239.255.42.99", interface = {};
  bool multicast = true;
  std::string coordinates = "auto";  // bones relative to "global", "local" or what "auto" finds
  std::vector<Tracker> trackers = {};
  rig::JointNames joints = {};  // by hand, where their names do not say whose they are
  float rate_hz = 100;          // of the frames made of trackers that have no common clock
  float delay_s = 0;            // by which frames wait so that bursts leave evenly; 0 = none
  int receive_buffer_bytes = 4 << 20;
  int max_connections = 64;      // tcp
  std::string usb_id = {};       // "1209:7690"; "" = any receiver (not of type usb)
  std::string serial = {};       // of the one USB device; "" = all
  int sender_limit_hz = 100000;  // datagrams of one address; 0 = any number
  friend bool operator==(const Source&, const Source&) = default;
};

// A further skeleton that styled motion is published on.
struct Output {
  std::string name;                     // the topic: styled/<performer>/<name>/
  std::string avatar;                   // file: .vrm, .glb, .gltf or .bvh
  std::string dialect = "auto";         // of a BVH
  rig::JointNames joints;               // by hand
  std::vector<std::string> performers;  // ids; empty = all
  std::string place;                    // file:line, for complaints
};

// How a source of a type listens; by name in source.type.
struct SourceType {
  std::string_view name;
  bool stream = false;             // TCP
  std::string_view usual_address;  // where nothing is said; "" = must be said
  bool usb = false;                // no address at all
};
inline constexpr std::array<SourceType, 11> kSourceTypes{{
    {"udp", false, ""},
    {"tcp", true, ""},
    {"mvn", false, "0.0.0.0:9763"},
    {"mvn-tcp", true, "0.0.0.0:9763"},
    {"mocopi", false, "0.0.0.0:12351"},
    {"rokoko", false, "0.0.0.0:14043"},
    {"slimevr", false, "0.0.0.0:6969"},
    {"natnet", false, "0.0.0.0:0"},
    {"slimevr-usb", false, "", true},
    {"usb", false, "", true},
    {"vmc", false, "0.0.0.0:39540"},
}};
const SourceType* FindSourceType(std::string_view name) noexcept;

// Who may connect to an ipc:// address.
struct Ipc {
  int mode = 0600;                 // of the socket's file; connecting takes the right to write
  std::vector<std::string> users;  // names or numbers; empty = whom the mode lets in
  friend bool operator==(const Ipc&, const Ipc&) = default;
};

struct Publish {
  std::string address = "tcp://127.0.0.1:7001";
  bool allow_unauthenticated_remote = false;
  Ipc ipc;
  int high_water_mark = 64;
  int send_buffer_bytes = 65536;
  int max_subscriptions = 1024;
  friend bool operator==(const Publish&, const Publish&) = default;
};

struct Control {
  std::string address = "tcp://127.0.0.1:7002";
  bool allow_unauthenticated_remote = false;
  Ipc ipc;
  friend bool operator==(const Control&, const Control&) = default;
};

// Keys of those who come from other machines: daemon/security/README.md.
struct Security {
  std::string keys;  // folder; "" = there are none
  friend bool operator==(const Security&, const Security&) = default;
};

struct Model {
  std::string weights;  // "" = as shipped
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
  float strength = 1.0F;
  float transition_s = 0.1F;
};

struct Preset {
  std::string name;
  std::vector<std::pair<std::string, float>> mix;  // style or alias, weight
  std::string place;                               // file:line, for complaints
};

// A change of style that is ready to be fired: by its name, or by the performers' timecode.
struct Cue {
  std::string name;
  std::string at;               // "HH:MM:SS:FF"; "" = by name only
  std::string performer = "*";  // an id, or "*"
  std::string style, preset;    // at most one of these two, the mix and `clear`
  std::vector<std::pair<std::string, float>> mix;
  bool clear = false, panic = false;
  std::optional<float> strength, transition_s;
  std::string only, input_style;
  std::string place;  // file:line, for complaints
};

// Open Sound Control, for consoles and control surfaces.
struct Osc {
  std::string listen;  // HOST:PORT; "" = off
  bool allow_unauthenticated_remote = false;
  friend bool operator==(const Osc&, const Osc&) = default;
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
  State state;
  Record record;
  Log log;
  Realtime realtime;
  // Where a key was said, for complaints: "source.0.listen" is at "stage.toml:12" or at
  // "STYLED_PUBLISH_ADDRESS". Keys that have their default are not there.
  std::map<std::string, std::string, std::less<>> places;
};

// A larger file is refused: the manual with all its comments has 13 KiB. It also bounds what a
// reload, beside a running show, takes of time and memory.
inline constexpr std::size_t kMaxFileBytes = 1 << 20;
// The most of [[source]], of [[output]], of [[cue]] and of presets each. Some of the checks compare
// each with each; so many take milliseconds.
inline constexpr std::size_t kMaxEntries = 4096;

// One setting from the command line ("section.key=value") or the environment.
struct Override {
  std::string key;    // "publish.address", "source.0.listen"
  std::string value;  // as TOML; what is no TOML is taken as a string
  std::string place;  // "--set publish.address" or "STYLED_PUBLISH_ADDRESS", for complaints
};

// STYLED_<SECTION>_<KEY> of `environment` ("NAME=value" strings, ended by null). Other names that
// begin with STYLED_ are not ours to judge, unless a section's name follows: then the key must
// exist.
Result<std::vector<Override>> EnvironmentOverrides(const char* const* environment);
// "section.key=value".
Result<Override> ParseOverride(const std::string& text);

// The defaults, then `file` ("" = none), then `overrides` in order, then Validate. Errors name
// file, line, key, what was expected and, for an unknown key, the nearest known one. Whatever is in
// the file's place - a pipe, a device, 100,000 nested tables, no text at all - gives an error.
// Start-up and reload only; allocates; any thread.
Result<Config> Load(const std::string& file, const std::vector<Override>& overrides);
// The same of a file's text; `name` is what complaints call it.
Result<Config> Parse(const std::string& text, const std::string& name,
                     const std::vector<Override>& overrides);

// The rules that span keys: at least one source, no port twice, loopback unless allowed, presets as
// the control socket would accept them (style names are checked against the weights, by the
// supervisor). Errors begin with the key.
Status Validate(const Config& config);

// Whether a socket at `address` asks for keys: it is not local, there are keys, and no word says
// that everybody may come in.
bool AsksForKeys(const Config& config, std::string_view address, bool allow_unauthenticated_remote);

// The performer and source name rule of WIRE.md, and SOURCE.NAME, both parts by it.
bool IsName(std::string_view text) noexcept;
bool IsPerformerId(std::string_view text) noexcept;

}  // namespace styled::config
