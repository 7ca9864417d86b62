#pragma once

#include <sys/types.h>

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"

// The files of stylize: which clips there are, what their outputs are called, and what must not be
// written over. Blocks on the disk; one thread.
namespace styled::stylize {

// Standard input or output, as a file's name.
inline constexpr const char* kStandard = "-";

// A clip to read.
struct Input {
  std::string file;   // or kStandard
  std::string name;   // {name}: without folder and extension; "stdin"
  std::string dir;    // {dir}: where it lies below the folder that was named, or "."
  std::string error;  // why it cannot be used; file is then what was named
};
// The clips that the command line names: files, kStandard, and of each folder its .bvh files in
// order of their names, with `recursive` also those of the folders in it. Hidden files are left
// out, links to folders not followed. A folder without clips is one input with an error.
std::vector<Input> FindInputs(const std::vector<std::string>& named, bool recursive);

// What a pattern's {name}, {dir} and {style} stand for.
struct Words {
  std::string name, dir, style;
};
// Fills a pattern, e.g. "out/{name}-{style}.bvh". Another word in braces is an error.
Result<std::string> FillPattern(const std::string& pattern, const Words& words);

// A file by what it is, whatever it is called: device and inode.
using FileId = std::pair<dev_t, ino_t>;

// Keeps a run from writing over what it reads, what it wrote before, and what was there.
class Guard {
 public:
  explicit Guard(bool overwrite) : overwrite_(overwrite) {}
  // A file that is read, for the message as `what`: "the input", "the avatar".
  void Reads(const std::string& file, const std::string& what);
  // Whether `file` may be written: it is no file that is read (also by a link of either kind), none
  // that this run has written, and new unless overwriting is allowed.
  Status Check(const std::string& file) const;
  // Writes by `write`, which gets the name of a file beside `file` with the same extension; that
  // file then takes its place, so that there is never half an output. Makes the folders on the way.
  Status Write(const std::string& file, const std::function<Status(const std::string&)>& write);

 private:
  bool overwrite_;
  std::vector<std::pair<FileId, std::string>> read_;
  std::set<FileId> written_;
};

// Writes by `write` to a temporary file with this extension, and that to standard output.
Status WriteToStandardOutput(const std::string& extension,
                             const std::function<Status(const std::string&)>& write);
// All of standard input, at most 2 GiB.
Result<std::string> ReadStandardInput();

}  // namespace styled::stylize
