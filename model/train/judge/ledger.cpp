#include "model/train/judge/ledger.h"

#include <ctime>
#include <fstream>
#include <vector>

#include "model/base/write_file.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr const char* kBegun = "begun, not ended";

std::string Begin(const TestUse& use) {
  std::string text;
  for (const std::string* cell :
       {&use.manifest, &use.weights, &use.files, &use.judges, &use.commit, &use.day}) {
    text += *cell + "\t";
  }
  return text;
}

// The lines; the head alone where there is no file.
Result<std::vector<std::string>> Read(const std::filesystem::path& ledger) {
  if (!std::filesystem::exists(ledger)) return std::vector<std::string>{kLedgerHead};
  std::ifstream in(ledger);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  if (in.bad() || lines.empty() || lines.front() != kLedgerHead) {
    return Status::Error(ledger.string() + ": line 1: expected the columns of a ledger of tests, " +
                         "found '" + (lines.empty() ? "" : lines.front()) + "'");
  }
  return lines;
}

Status Write(const std::vector<std::string>& lines, const std::filesystem::path& ledger) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return WriteFileAtomically(ledger.string(), text, 0644);
}

}  // namespace

TestUse UseOf(const nlohmann::json& provenance, const std::string& commit) {
  char day[11];
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  std::strftime(day, sizeof day, "%Y-%m-%d", gmtime_r(&now, &parts));
  return {.manifest = provenance["manifest"].get<std::string>(),
          .weights = provenance["weights"]["sha256"].get<std::string>(),
          .files = provenance["weights"]["file"].get<std::string>(),
          .judges = provenance["judges"]["sha256"].get<std::string>(),
          .commit = commit,
          .day = day};
}

std::string LedgerFigures(const nlohmann::json& report) {
  const nlohmann::json& sets = report["judges"];
  const auto judge_of = [&sets](const std::string& set_key, std::size_t judge) {
    for (const nlohmann::json& set : sets) {
      if (set["key"] == set_key) return set["judges"][judge];
    }
    return nlohmann::json::object();
  };
  const auto text = [](const nlohmann::json& judge) {
    const auto number = [&judge](const char* key) {
      const auto found = judge.find(key);
      return found != judge.end() && found->is_number() ? found->get<double>() : kNotMeasured;
    };
    return Padded(number("value"), number("spread"), 0, 3);
  };
  std::string figures;
  const nlohmann::json& own = sets.back();
  for (std::size_t i = 0; i < own["judges"].size(); ++i) {
    figures += (figures.empty() ? "" : "; ") + own["judges"][i]["key"].get<std::string>() + " " +
               text(own["judges"][i]) + " (" + text(judge_of("offset", i)) + ", " +
               text(judge_of("real", i)) + ")";
  }
  return figures;
}

Status BeginTest(const TestUse& use, bool again, const std::filesystem::path& ledger) {
  auto lines = Read(ledger);
  if (!lines.ok()) return lines.status();
  const std::string same = use.manifest + "\t" + use.weights + "\t";
  for (std::size_t i = 1; i < lines.value().size() && !again; ++i) {
    if (!lines.value()[i].starts_with(same)) continue;
    return Status::Error(ledger.string() + ": line " + std::to_string(i + 1) + ": " + use.files +
                         " was judged on the test split of " + use.manifest +
                         " before; a test split is used once for the same weights, or knowingly "
                         "with --again");
  }
  lines.value().push_back(Begin(use) + kBegun);
  return Write(lines.value(), ledger);
}

Status EndTest(const TestUse& use, const std::string& figures,
               const std::filesystem::path& ledger) {
  auto lines = Read(ledger);
  if (!lines.ok()) return lines.status();
  const std::string begun = Begin(use) + kBegun;
  for (auto line = lines.value().rbegin(); line != lines.value().rend(); ++line) {
    if (*line != begun) continue;
    *line = Begin(use) + figures;
    return Write(lines.value(), ledger);
  }
  return Status::Error(ledger.string() + ": the line of this use is gone; expected '" + begun +
                       "'");
}

}  // namespace styled::judge
