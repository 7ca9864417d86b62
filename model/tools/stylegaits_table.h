#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/train/judge/gaits.h"

namespace styled {

// The rows of one group of sources.
struct GaitRows {
  explicit GaitRows(std::size_t styles)
      : network(styles), offset(styles), unstyled(styles), real(styles) {}

  judge::GaitTable network, offset, unstyled, real;
};

// Prints each row's figures by style, then all rows' means over walks, runs and both. `styles`: the
// names; only those of `chosen` are printed.
void Print(const std::string& title, const std::vector<std::string>& styles,
           const std::vector<std::size_t>& chosen, const GaitRows& rows);
nlohmann::json ToJson(const std::vector<std::string>& styles,
                      const std::vector<std::size_t>& chosen, const GaitRows& rows);

// The seconds that examples, judges and real parts have of each of the judges' styles.
void PrintParts(const clip::Manifest& judges, const judge::GaitParts& parts);
nlohmann::json ToJson(const clip::Manifest& judges, const judge::GaitParts& parts);

}  // namespace styled
