#pragma once

#include <map>
#include <string>
#include <string_view>

#include "model/base/status.h"

namespace styled::web {

struct PageFile {
  std::string_view type;  // MIME
  std::string bytes;
  // Its name changes with its content: browsers may cache it without revalidation.
  bool forever = false;
};

// The built page, read once into memory. Files outside it cannot be requested, whatever the path.
class Page {
 public:
  Page() = default;  // for a gateway without a page

  // Reads every regular file below `folder`. Refuses a folder without index.html, or with more than
  // 64 MiB.
  static Result<Page> Load(const std::string& folder);

  // The file for a request target ("/", "/assets/index-1234.js"; a query is ignored); null if there
  // is none. Valid during the lifetime of the page.
  const PageFile* Find(std::string_view target) const;
  bool empty() const { return files_.empty(); }

 private:
  std::map<std::string, PageFile, std::less<>> files_;
};

// The folder of the page, relative to the program: in the build tree or as installed; "" if neither
// exists.
std::string FindPage();

}  // namespace styled::web
