#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "proto/styled/v1/control.pb.h"
#include "tests/support/daemon.h"

// Requests that are sent to the daemon to harm it, at least one for each command: a command of
// control.proto without a row fails tables_test.cpp. The rows of rigs are those of
// proto/rigs/types.h (rigs_test.cpp), those of files are in files_test.cpp.
namespace styled::hostile {

// The data that an admitted attacker can get: true data to start from.
struct Loot {
  std::string style_file;  // of a style that was made, as export_style gives it
  v1::Checkpoint checkpoint;
};

// Requests that an operator's client sends again and again.
struct RequestAttack {
  std::string command;  // the field of Request.command
  std::string name;     // letters and digits
  std::function<v1::Request(const Loot&)> make;
};
inline void PrintTo(const RequestAttack& attack, std::ostream* out) { *out << attack.name; }
std::vector<RequestAttack> RequestAttacks();

// A BVH text of a walk's skeleton and at most `bytes` bytes: 30 s of copies of one frame.
std::string LargeBvh(std::size_t bytes);
// A glTF binary of a JSON chunk alone.
std::string Glb(const std::string& json);

}  // namespace styled::hostile
