#include "model/train/curve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace styled::train {
namespace {

constexpr double kWidth = 640, kPanel = 110, kLeft = 60, kTop = 22;

std::string Format(const char* format, double a, double b = 0) {
  char text[96];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

// One column over minutes; its lowest and highest values are written at the axis.
std::string Panel(const std::string& name, const std::vector<double>& minutes,
                  const std::vector<double>& values, double top) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(1e-9, *high - *low);
  const double last = std::max(1e-9, minutes.back());
  const double height = kPanel - 2 * kTop;
  std::string points;
  for (std::size_t i = 0; i < values.size(); ++i) {
    points += Format("%.1f,%.1f ", kLeft + minutes[i] / last * (kWidth - kLeft - 10),
                     top + kTop + (1 - (values[i] - *low) / span) * height);
  }
  std::ostringstream out;
  out << "<text x=\"" << kLeft << "\" y=\"" << top + 14 << "\" font-weight=\"bold\">" << name << " "
      << Format("%.3f", values.back()) << "</text>\n<text x=\"4\" y=\"" << top + kTop + 6 << "\">"
      << Format("%.3g", *high) << "</text>\n<text x=\"4\" y=\"" << top + kTop + height << "\">"
      << Format("%.3g", *low)
      << "</text>\n<polyline fill=\"none\" stroke=\"#e0651a\" stroke-width=\"2\" points=\""
      << points << "\"/>\n";
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
      << Format("0 to %.0f minutes, %.0f iterations", minutes.back(), columns[0].back())
      << "</text>\n</svg>\n";
  if (!out.flush()) return Status::Error(svg.string() + ": cannot be written");
  return Status::Ok();
}

}  // namespace styled::train
