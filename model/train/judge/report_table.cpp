#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>

#include "model/train/judge/report.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

// least share of windows mistaken for another style that is printed
constexpr double kWorthSaying = 0.05;

nlohmann::json ShareToJson(const Share& share) {
  return {{"value", Value(Measured(share))},
          {"spread", Value(share.spread())},
          {"low", share.low},
          {"high", share.high},
          {"windows", share.windows},
          {"worst", share.worst}};
}

double Deepest_cm(const FeetFigures& feet) {
  return feet.penetration_cm.count > 0 ? feet.deepest_cm : kNotMeasured;
}

// The Frechet distances with their names in JSON, in the order of the table.
struct DistanceColumn {
  const char* key;
  double Distances::*of;
  int width;
};
constexpr std::array<DistanceColumn, 6> kDistances{{
    {"fmd", &Distances::fmd, 7},
    {"fmd_real_real", &Distances::fmd_real, 5},
    {"fmd_neutral_target", &Distances::fmd_neutral, 6},
    {"content_fmd", &Distances::content_fmd, 6},
    {"content_fmd_real_real", &Distances::content_fmd_real, 5},
    {"content_fmd_neutral_target", &Distances::content_fmd_neutral, 5},
}};

// A share as a table's cell: the spread over judges where there are several, and the interval.
std::string Interval(const Share& share) {
  if (share.windows <= 0) return "      -          ";
  char text[48];
  std::snprintf(text, sizeof text, " [%.2f %.2f]", share.low, share.high);
  return Padded(share, 5, 3) + text;
}

std::string Joined(std::initializer_list<std::string> cells) {
  std::string text;
  for (const std::string& cell : cells) text.append(text.empty() ? 0 : 1, ' ').append(cell);
  return text;
}

std::string ShiftsAndDistances(const StyleFigures& of) {
  const auto both = [](const Expression& expression) {
    return Joined({Padded(expression.fraction, 5, 2), Padded(expression.cosine, 5, 2)});
  };
  std::string text =
      Joined({both(of.expression), both(of.expression_walk), both(of.expression_real)});
  for (const DistanceColumn& column : kDistances) {
    text += " " + Padded(of.Distance(column.of), of.DistanceSpread(column.of), column.width, 2);
  }
  return text;
}

std::string JerkAndFeet(const StyleFigures& of) {
  return Joined({Padded(of.jitter_stream, 6, 2), Padded(of.jitter_clip, 5, 2),
                 Padded(of.jitter_real, 5, 2), Padded(Measured(of.feet.skate_in_cm_s), 6, 1), ">",
                 Padded(Measured(of.feet.skate_out_cm_s), 4, 1),
                 Padded(Measured(of.feet.penetration_cm), 4, 2),
                 Padded(Deepest_cm(of.feet), 4, 1)});
}

void PrintHeader(bool several) {
  const int share = several ? 7 : 0;  // characters of " ±0.003"
  const int distance = several ? 6 : 0;
  std::printf("%-10s", "style");
  for (const char* const share_of : {"SRA", "CRA"}) {
    const std::string title = std::string(share_of) + (several ? " judges [95 %]" : " [95 %]");
    std::printf(" %-*s %-*s", 17 + share, title.c_str(), 5 + share,
                share_of[0] == 'S' ? "real" : "in");
  }
  std::printf("  %-11s %-11s %-11s ", " expr   cos", " walk   cos", " real   cos");
  for (const char* const title : {"FMD", "FMD-c"}) {
    const DistanceColumn* const column = &kDistances[title[3] == '-' ? 3 : 0];
    std::printf(" %*s%*s %*s%*s %*s%*s", column[0].width, title, distance, "", column[1].width,
                "real", distance, "", column[2].width, "neutr", distance, "");
  }
  std::printf("  %5s %5s %5s  %-12s %-9s\n", "jit120", "jit30", "real", " skate cm/s", "floor cm");
}

// Over the styles that have them, by judge.
std::vector<Distances> MeanDistances(std::span<const StyleFigures> styles) {
  std::vector<Distances> means;
  for (const StyleFigures& style : styles) {
    means.resize(std::max(means.size(), style.distances.size()));
  }
  for (std::size_t judge = 0; judge < means.size(); ++judge) {
    for (const DistanceColumn& column : kDistances) {
      Mean mean;
      for (const StyleFigures& style : styles) {
        if (judge < style.distances.size()) mean.Add(style.distances[judge].*column.of);
      }
      means[judge].*column.of = Measured(mean);
    }
  }
  return means;
}

}  // namespace

std::string Evaluator::CellName(int cell) const {
  if (cell < 0) return "none";
  return manifest_.styles[cell / contents_].name + " " + manifest_.contents[cell % contents_];
}

nlohmann::json Evaluator::ToJson(const Figures& figures) const {
  const auto with_worst = [this](const Share& share) {
    nlohmann::json json = ShareToJson(share);
    json["worst_cell"] = CellName(share.worst_cell);
    return json;
  };
  nlohmann::json json = {{"title", figures.name},
                         {"sra", with_worst(figures.sra)},
                         {"sra_first_windows", ShareToJson(figures.sra_first)},
                         {"cra", with_worst(figures.cra)},
                         {"cra_of_inputs", with_worst(figures.cra_input)},
                         {"sra_with_unknown", ShareToJson(figures.sra_with_unknown)},
                         {"unknown_to_style_judge", nlohmann::json::array()}};
  const StyleFigures mean = MeanOf(figures);
  for (const DistanceColumn& column : kDistances) {
    json["mean"][column.key] = Value(mean.Distance(column.of));
    json["mean"][std::string(column.key) + "_spread"] = Value(mean.DistanceSpread(column.of));
  }
  for (const int cell : figures.unknown) json["unknown_to_style_judge"].push_back(CellName(cell));
  for (int style = 1; style < styles_; ++style) {
    const StyleFigures& of = figures.styles[style];
    json["styles"][manifest_.styles[style].name] = {
        {"sra", with_worst(of.sra)},
        {"sra_of_real", with_worst(of.sra_real)},
        {"cra", with_worst(of.cra)},
        {"cra_of_inputs", with_worst(of.cra_input)},
        {"expression", Value(of.expression.fraction)},
        {"expression_cosine", Value(of.expression.cosine)},
        {"expression_walk", Value(of.expression_walk.fraction)},
        {"expression_walk_cosine", Value(of.expression_walk.cosine)},
        {"expression_of_training_clips", Value(of.expression_real.fraction)},
        {"expression_cosine_of_training_clips", Value(of.expression_real.cosine)},
        {"fmd_windows", of.fmd_windows},
        {"jitter_120", Value(of.jitter_stream)},
        {"jitter_30", Value(of.jitter_clip)},
        {"jitter_120_of_real", Value(of.jitter_real)},
        {"skate_in_cm_s", Value(Measured(of.feet.skate_in_cm_s))},
        {"skate_out_cm_s", Value(Measured(of.feet.skate_out_cm_s))},
        {"penetration_cm", Value(Measured(of.feet.penetration_cm))},
        {"deepest_cm", Value(Deepest_cm(of.feet))}};
    for (const DistanceColumn& column : kDistances) {
      nlohmann::json& here = json["styles"][manifest_.styles[style].name];
      here[column.key] = Value(of.Distance(column.of));
      here[std::string(column.key) + "_spread"] = Value(of.DistanceSpread(column.of));
    }
    nlohmann::json& by_content = json["styles"][manifest_.styles[style].name]["by_content"];
    nlohmann::json& taken_for = json["styles"][manifest_.styles[style].name]["taken_for"];
    for (int other = 0; other < styles_; ++other) {
      taken_for[manifest_.styles[other].name] = of.taken_for[other];
    }
    for (int content = 0; content < contents_; ++content) {
      const Expression& expression = of.expression_by_content[content];
      by_content[manifest_.contents[content]] = {{"sra", Value(of.sra_by_content[content])},
                                                 {"cra", Value(of.cra_by_content[content])},
                                                 {"expression", Value(expression.fraction)},
                                                 {"expression_cosine", Value(expression.cosine)}};
    }
  }
  return json;
}

nlohmann::json Evaluator::RealToJson() const {
  nlohmann::json json = {{"style", ShareToJson(real_style_)},
                         {"content", ShareToJson(real_content_)}};
  for (int style = 0; style < styles_; ++style) {
    json["styles"][manifest_.styles[style].name] = {
        {"style", ShareToJson(MacroShare(OfStyle(real_styles_, style, contents_), kIntervalSeed))},
        {"content",
         ShareToJson(MacroShare(OfStyle(real_contents_, style, contents_), kIntervalSeed))}};
  }
  return json;
}

StyleFigures Evaluator::MeanOf(const Figures& figures) const {
  StyleFigures mean;
  // The mean of a figure over the styles that have it.
  const auto average = [&](const auto& figure) {
    Mean of_styles;
    for (int style = 1; style < styles_; ++style) {
      StyleFigures of = figures.styles[style];
      if (std::isfinite(figure(of))) of_styles.Add(figure(of));
    }
    figure(mean) = Measured(of_styles);
  };
  for (Expression StyleFigures::*expression :
       {&StyleFigures::expression, &StyleFigures::expression_walk,
        &StyleFigures::expression_real}) {
    average([=](StyleFigures& of) -> double& { return (of.*expression).fraction; });
    average([=](StyleFigures& of) -> double& { return (of.*expression).cosine; });
  }
  for (double StyleFigures::*figure :
       {&StyleFigures::jitter_stream, &StyleFigures::jitter_clip, &StyleFigures::jitter_real}) {
    average([=](StyleFigures& of) -> double& { return of.*figure; });
  }
  mean.distances = MeanDistances(figures.styles);
  std::vector<ClipVerdict> real;  // of the styles that are judged
  for (int style = 1; style < styles_; ++style) {
    const StyleFigures& of = figures.styles[style];
    mean.feet.Add(of.feet);
    if (of.sra.windows <= 0) continue;
    const std::vector<ClipVerdict> of_style = OfStyle(real_styles_, style, contents_);
    real.insert(real.end(), of_style.begin(), of_style.end());
  }
  mean.sra_real = MacroShare(real, kIntervalSeed, 0);
  mean.sra = figures.sra;
  mean.cra = figures.cra;
  mean.cra_input = figures.cra_input;
  return mean;
}

void Evaluator::Print(const Figures& figures, const Figures* offset) const {
  std::printf("\n%s\n", figures.name.c_str());
  PrintHeader(judges_.settings().count > 1);
  const auto row = [](const char* name, const StyleFigures& of) {
    std::printf("%-10.10s %s %s %s %s  %s %s\n", name, Interval(of.sra).c_str(),
                Padded(of.sra_real, 5, 3).c_str(), Interval(of.cra).c_str(),
                Padded(of.cra_input, 5, 3).c_str(), ShiftsAndDistances(of).c_str(),
                JerkAndFeet(of).c_str());
  };
  for (int style = 1; style < styles_; ++style) {
    row(manifest_.styles[style].name.c_str(), figures.styles[style]);
  }
  row("mean", MeanOf(figures));
  if (offset != nullptr) row("offset", MeanOf(*offset));
  std::printf(
      "%.0f windows; first windows SRA %.3f; CRA over inputs %.3f; worst SRA %.2f (%s), worst CRA "
      "%.2f (%s)\n",
      figures.sra.windows, figures.sra_first.value,
      figures.cra.value / std::max(1e-9, figures.cra_input.value), figures.sra.worst,
      CellName(figures.sra.worst_cell).c_str(), figures.cra.worst,
      CellName(figures.cra.worst_cell).c_str());
  if (!figures.unknown.empty()) {
    std::printf(
        "%zu cells are in no SRA, since the judge has never seen a real one (with them it is %.3f "
        "[%.2f %.2f]):",
        figures.unknown.size(), figures.sra_with_unknown.value, figures.sra_with_unknown.low,
        figures.sra_with_unknown.high);
    for (const int cell : figures.unknown) std::printf(" %s;", CellName(cell).c_str());
    std::printf("\n");
  }
  for (int style = 1; style < styles_; ++style) {
    const std::vector<double>& taken_for = figures.styles[style].taken_for;
    std::string others;
    for (int other = 0; other < styles_; ++other) {
      if (other == style || taken_for[other] < kWorthSaying) continue;
      char text[80];
      std::snprintf(text, sizeof text, " %s %.2f", manifest_.styles[other].name.c_str(),
                    taken_for[other]);
      others += text;
    }
    if (!others.empty()) {
      std::printf("%s is mistaken for%s\n", manifest_.styles[style].name.c_str(), others.c_str());
    }
  }
}

}  // namespace styled::judge
