#include "model/train/curve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace styled::train {
namespace {

// Pixels. A panel has its title above and the numbers of its minutes below.
constexpr double kWidth = 640, kPanel = 120, kLeft = 60, kTop = 22, kBottom = 24;
constexpr double kPlot = kWidth - kLeft - 16;  // width of the plot

std::string Format(const char* format, double a, double b = 0) {
  char text[128];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

// A step of 1, 2 or 5 times a power of ten that divides `span` into four to ten parts.
double TickStep(double span) {
  const double decade = std::pow(10.0, std::floor(std::log10(std::max(1e-9, span) / 4)));
  for (const double step : {5.0, 2.0}) {
    if (span / (step * decade) >= 4) return step * decade;
  }
  return decade;
}

std::string Line(double x1, double y1, double x2, double y2, const char* colour) {
  return "<path stroke=\"" + std::string(colour) + "\" fill=\"none\" d=\"" +
         Format("M%.1f %.1f", x1, y1) + Format("L%.1f %.1f\"/>\n", x2, y2);
}

std::string Text(double x, double y, const char* anchor, const std::string& text) {
  return Format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"", x, y) + anchor + "\">" + text +
         "</text>\n";
}

// The axes of a panel between `top` and `bottom`: minutes to the right, with a line and a number at
// each tick; at the left the lowest and the highest value.
std::string Axes(double last_minute, double low, double high, double top, double bottom) {
  std::string out;
  const double step = TickStep(last_minute);
  for (int tick = 0; tick * step <= last_minute * 1.0001; ++tick) {
    const double x = kLeft + tick * step / last_minute * kPlot;
    out += Line(x, top, x, bottom + 3, "#ddd");
    out += Text(x, bottom + 14, "middle", Format("%.4g", tick * step));
  }
  for (const auto& [value, y] : {std::pair(high, top), std::pair(low, bottom)}) {
    out += Line(kLeft - 3, y, kLeft + kPlot, y, "#999");
    out += Text(kLeft - 6, y + 4, "end", Format("%.3g", value));
  }
  return out + Line(kLeft, top, kLeft, bottom, "#999");
}

// One column over minutes, with its last value in the title.
std::string Panel(const std::string& name, const std::vector<double>& minutes,
                  const std::vector<double>& values, double top) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(1e-9, *high - *low);
  const double last = std::max(1e-9, minutes.back());
  const double bottom = top + kPanel - kBottom;
  std::string points;
  for (std::size_t i = 0; i < values.size(); ++i) {
    points += Format("%.1f,%.1f ", kLeft + minutes[i] / last * kPlot,
                     bottom - (values[i] - *low) / span * (bottom - top - kTop));
  }
  std::ostringstream out;
  out << "<text x=\"" << kLeft << "\" y=\"" << top + 14 << "\" font-weight=\"bold\">" << name << " "
      << Format("%.3f", values.back()) << "</text>\n"
      << Axes(last, *low, *high, top + kTop, bottom)
      << "<polyline fill=\"none\" stroke=\"#e0651a\" stroke-width=\"2\" points=\"" << points
      << "\"/>\n";
  return out.str();
}

}  // namespace

Status DrawCurve(const std::filesystem::path& csv, const std::filesystem::path& svg) {
  std::ifstream in(csv);
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  for (std::string line; std::getline(in, line);) {
    std::istringstream cells(line);
    std::vector<std::string> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    if (names.empty()) {
      names = row;
      columns.resize(names.size());
    } else if (row.size() == names.size() && row != names) {
      for (std::size_t i = 0; i < row.size(); ++i)
        columns[i].push_back(std::strtod(row[i].c_str(), nullptr));
    }
  }
  if (names.size() < 3 || columns[0].empty()) {
    return Status::Error(csv.string() +
                         ": found no row, expected iteration, elapsed_s and figures");
  }
  std::vector<double> minutes = columns[1];
  for (double& value : minutes) value /= 60;
  const double height = kPanel * static_cast<double>(names.size() - 2) + 20;
  std::ofstream out(svg);
  out << Format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" ", kWidth,
                height)
      << "font-family=\"sans-serif\" font-size=\"12\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  for (std::size_t i = 2; i < names.size(); ++i) {
    out << Panel(names[i], minutes, columns[i], kPanel * static_cast<double>(i - 2));
  }
  out << "<text x=\"" << kLeft << "\" y=\"" << height - 6 << "\">"
      << Format("minutes; %.1f of them, %.0f iterations", minutes.back(), columns[0].back())
      << "</text>\n</svg>\n";
  if (!out.flush()) return Status::Error(svg.string() + ": cannot be written");
  return Status::Ok();
}

}  // namespace styled::train
