#pragma once

#include <map>
#include <string>
#include <string_view>

#include "model/base/status.h"

namespace styled::web {

struct PageFile {
  std::string_view type;  // MIME
  std::string bytes;
  bool forever = false;  // its name changes with its content: browsers need not ask again
};

// The built page, read once: what is not in memory cannot be asked for, whatever the path says.
class Page {
 public:
  Page() = default;  // of a gateway without one

  // Every regular file below `folder`. Refuses a folder without index.html, or of more than 64 MiB.
  static Result<Page> Load(const std::string& folder);

  // The file of a request target ("/", "/assets/index-1234.js", a query is ignored); null where
  // there is none. Valid as long as the page.
  const PageFile* Find(std::string_view target) const;
  bool empty() const { return files_.empty(); }

 private:
  std::map<std::string, PageFile, std::less<>> files_;
};

// Where the page is, seen from the program: the build tree's or the installed one; "" where neither
// is there.
std::string FindPage();

}  // namespace styled::web
