#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/judge/data.h"

namespace styled::judge {

// The files that `weights` names: one, or several joined by "+", each a file or a shipped name.
Result<std::vector<std::filesystem::path>> JoinedFiles(const std::string& weights);

// They are combined as the daemon combines them. The result has a space of styles. Errors name the
// weights.
Result<std::shared_ptr<const net::Stylizer>> LoadJoined(const std::string& weights);

// Such weights with a style for each of `of`: made as the daemon makes it from all clips that the
// manifest `examples` has of that style, of which neither names nor labels are used. Styles without
// an example are absent. Errors name the file, or say that no style has one.
Result<Styler> LoadByExamples(const std::string& weights, const std::filesystem::path& examples,
                              const std::filesystem::path& data, const clip::Manifest& of);

}  // namespace styled::judge
