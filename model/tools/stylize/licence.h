#pragma once

#include <filesystem>
#include <string>

#include "model/net/stylizer.h"

namespace styled::stylize {

// The terms of a file of weights for people: its licence and credits, those of its styles that have
// their own, and the licences of the weights installed beside it. Lines end in a newline.
std::string LicenceText(const std::filesystem::path& file, const net::Model& model);

}  // namespace styled::stylize
