#pragma once

#include <sys/types.h>

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"

// The files of stylize: the input clips, the names of their outputs, and the files that must not be
// overwritten. Blocks on the disk; one thread.
namespace styled::stylize {

// Standard input or output, as a file's name.
inline constexpr const char* kStandard = "-";

// A clip to read.
struct Input {
  std::string file;   // or kStandard
  std::string name;   // {name}: the file's name without folder and extension
  std::string dir;    // {dir}: its folder relative to the folder that was named, or "."
  std::string error;  // why it cannot be used; file is then the name on the command line
};
// The clips on the command line: files, kStandard, and the .bvh, .glb and .vrma files of each
// folder in order of their names, with `recursive` also those of its subfolders. Hidden files are
// left out, links to folders not followed. A folder without clips is one input with an error.
std::vector<Input> FindInputs(const std::vector<std::string>& named, bool recursive);

// The values of a pattern's {name}, {dir} and {style}.
struct Words {
  std::string name, dir, style;
};
// Fills a pattern, e.g. "out/{name}-{style}.bvh". Another word in braces is an error.
Result<std::string> FillPattern(const std::string& pattern, const Words& words);

// The identity of a file, independent of its name: device and inode.
using FileId = std::pair<dev_t, ino_t>;

// Keeps a run from overwriting its inputs, its own outputs, and existing files.
class Guard {
 public:
  explicit Guard(bool overwrite) : overwrite_(overwrite) {}
  // A file that is read, for the message as `what`: "the input", "the avatar".
  void Reads(const std::string& file, const std::string& what);
  // Whether `file` may be written: it is not an input (also by a link of either kind), was not
  // written by this run, and is new unless overwriting is allowed.
  Status Check(const std::string& file) const;
  // Writes with `write`, which gets the name of a temporary file beside `file` with the same
  // extension. That file then replaces `file`, so that an output is never incomplete. Creates
  // missing folders.
  Status Write(const std::string& file, const std::function<Status(const std::string&)>& write);

 private:
  bool overwrite_;
  std::vector<std::pair<FileId, std::string>> read_;
  std::set<FileId> written_;
};

// Writes with `write` to a temporary file with this extension, and copies that to standard output.
Status WriteToStandardOutput(const std::string& extension,
                             const std::function<Status(const std::string&)>& write);
// All of standard input, at most 2 GiB.
Result<std::string> ReadStandardInput();

}  // namespace styled::stylize
