// The tables of stylegaits, and their JSON.
#include "model/tools/stylegaits_table.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "model/train/judge/nets.h"
#include "model/train/judge/text.h"

namespace styled {
namespace {

using judge::GaitFigures;
using judge::GaitParts;
using judge::GaitTable;
using judge::kGaitKinds;
using judge::Mean;
using judge::PerGait;

struct Column {
  const char* title;
  const char* key;
  Mean GaitFigures::*of;
  int decimals;
};
constexpr std::array<Column, 6> kColumns{{
    {"SRA", "recognized", &GaitFigures::recognized, 2},
    {"movement", "movement_recognized", &GaitFigures::moves, 2},
    {"distance", "movement", &GaitFigures::movement, 2},
    {"jerk", "jerk", &GaitFigures::jerk, 2},
    {"skate", "skate_cm_s", &GaitFigures::skate_cm_s, 1},
    {"(input)", "input_skate_cm_s", &GaitFigures::input_skate_cm_s, 1},
}};

std::array<std::pair<const char*, const judge::GaitTable*>, 4> TablesOf(const GaitRows& rows) {
  return {{{"network", &rows.network},
           {"constant offset", &rows.offset},
           {"unstyled", &rows.unstyled},
           {"real", &rows.real}}};
}

// The characters of " ±0.03", in a column of several judges.
int MoreOf(const GaitTable& table, const Column& column) {
  const PerGait<GaitFigures> means = judge::OverStyles(table);
  const bool several = std::any_of(means.begin(), means.end(), [&](const GaitFigures& gait) {
    return (gait.*column.of).by_judge.size() > 1;
  });
  return several ? 6 : 0;
}

// Walks and runs side by side.
void PrintHeader(const char* title, const GaitTable& table) {
  std::printf("%-16s", title);
  for (const Column& column : kColumns) {
    std::printf(" %*s", 11 + 2 * MoreOf(table, column), column.title);
  }
  std::printf("\n%-16s", "");
  for (const Column& column : kColumns) {
    const int more = MoreOf(table, column);
    std::printf("   %*s%*s", 4 + more, "walk", 5 + more, "run");
  }
  std::printf("\n");
}

std::string Cells(const PerGait<GaitFigures>& of) {
  std::string text;
  for (const Column& column : kColumns) {
    text += "  ";
    for (const GaitFigures& gait : of) {
      text += judge::Padded(gait.*column.of, 5, column.decimals);
    }
  }
  return text;
}

void PrintMeans(const char* title, const GaitFigures& of) {
  std::printf("  %-24s", title);
  for (const Column& column : kColumns) {
    std::printf("%s", judge::Padded(of.*column.of, 9, column.decimals).c_str());
  }
  std::printf("\n");
}

nlohmann::json FiguresJson(const GaitFigures& of) {
  nlohmann::json json;
  for (const Column& column : kColumns) {
    json[column.key] = judge::Value(judge::Measured(of.*column.of));
    if (!(of.*column.of).by_judge.empty()) {
      json[std::string(column.key) + "_spread"] = judge::Value((of.*column.of).spread());
    }
  }
  return json;
}

nlohmann::json GaitsJson(const PerGait<GaitFigures>& of) {
  nlohmann::json json;
  for (std::size_t gait = 0; gait < kGaitKinds; ++gait) {
    json[judge::kGaitNames[gait]] = FiguresJson(of[gait]);
  }
  return json;
}

double Seconds(std::size_t frames) { return static_cast<double>(frames) / judge::kJudgeRate_hz; }

double ExampleSeconds(const GaitParts& parts, std::size_t style, std::size_t gait) {
  return style < parts.examples.size() ? Seconds(parts.examples[style][gait].size()) : 0;
}

// By content, of one style.
std::vector<double> JudgesSeconds(const GaitParts& parts, std::size_t style, std::size_t contents) {
  std::vector<double> seconds(contents, 0);
  for (const train::TrainingClip& clip : parts.judges) {
    if (static_cast<std::size_t>(clip.style) != style) continue;
    seconds[static_cast<std::size_t>(clip.content)] += Seconds(clip.poses.size());
  }
  return seconds;
}

double RealSeconds(const GaitParts& parts, std::size_t style, const std::string& content) {
  double seconds = 0;
  for (const judge::RealPart& part : parts.real) {
    const bool counts = static_cast<std::size_t>(part.style) == style && part.content == content;
    if (counts) seconds += Seconds(part.poses.size());
  }
  return seconds;
}

}  // namespace

void Print(const std::string& title, const std::vector<std::string>& styles,
           const std::vector<std::size_t>& chosen, const GaitRows& rows) {
  std::printf("\n%s\n", title.c_str());
  for (const auto& [name, table] : TablesOf(rows)) {
    PrintHeader(name, *table);
    for (const std::size_t style : chosen) {
      std::printf("%-16s%s\n", ("  " + styles[style]).c_str(), Cells((*table)[style]).c_str());
    }
    std::printf("%-16s%s\n", "  mean", Cells(judge::OverStyles(*table)).c_str());
  }
  std::printf("%-26s", "means over styles");
  for (const Column& column : kColumns) {
    std::printf("%*s", 9 + MoreOf(rows.network, column), column.title);
  }
  std::printf("\n");
  const std::array<const char*, kGaitKinds> titles{"walks", "runs"};
  for (std::size_t gait = 0; gait < kGaitKinds; ++gait) {
    for (const auto& [name, table] : TablesOf(rows)) {
      const std::string row = std::string(name) + ", " + titles[gait];
      PrintMeans(row.c_str(), judge::OverStyles(*table)[gait]);
    }
  }
  for (const auto& [name, table] : TablesOf(rows)) {
    const std::string row = std::string(name) + ", both";
    PrintMeans(row.c_str(), judge::OverGaits(judge::OverStyles(*table)));
  }
}

nlohmann::json ToJson(const std::vector<std::string>& styles,
                      const std::vector<std::size_t>& chosen, const GaitRows& rows) {
  nlohmann::json json;
  for (const auto& [name, table] : TablesOf(rows)) {
    nlohmann::json& row = json[name];
    for (const std::size_t style : chosen) {
      row["styles"][styles[style]] = GaitsJson((*table)[style]);
    }
    row["mean"] = GaitsJson(judge::OverStyles(*table));
    row["mean"]["both"] = FiguresJson(judge::OverGaits(judge::OverStyles(*table)));
  }
  return json;
}

void PrintParts(const clip::Manifest& judges, const GaitParts& parts) {
  std::printf("%-16s%8s%6s |", "seconds", "example", "run");
  for (const std::string& content : judges.contents) std::printf(" %8s", content.c_str());
  std::printf(" | %9s%6s%6s\n", "real walk", "run", "dash");
  for (std::size_t style = 0; style < judges.styles.size(); ++style) {
    std::printf("%-16s%8.1f%6.1f |", judges.styles[style].name.c_str(),
                ExampleSeconds(parts, style, 0), ExampleSeconds(parts, style, 1));
    for (const double seconds : JudgesSeconds(parts, style, judges.contents.size())) {
      std::printf(" %8.1f", seconds);
    }
    std::printf(" | %9.1f%6.1f%6.1f\n", RealSeconds(parts, style, "walk"),
                RealSeconds(parts, style, "run"), RealSeconds(parts, style, "dash"));
  }
}

nlohmann::json ToJson(const clip::Manifest& judges, const GaitParts& parts) {
  nlohmann::json json;
  for (std::size_t style = 0; style < judges.styles.size(); ++style) {
    nlohmann::json& of = json[judges.styles[style].name];
    const std::vector<double> seen = JudgesSeconds(parts, style, judges.contents.size());
    for (std::size_t i = 0; i < seen.size(); ++i) of["judges_s"][judges.contents[i]] = seen[i];
    for (std::size_t gait = 0; gait < kGaitKinds; ++gait) {
      of["example_s"][judge::kGaitNames[gait]] = ExampleSeconds(parts, style, gait);
    }
    for (const char* content : {"walk", "run", "dash"}) {
      of["real_s"][content] = RealSeconds(parts, style, content);
    }
  }
  return json;
}

}  // namespace styled
