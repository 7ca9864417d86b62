#include "clients/doctor/counter_words.h"

#include <algorithm>
#include <array>

#include "clients/doctor/operating_page.h"

namespace styled::doctor {
namespace {

// A cell without Markdown's marks: `code`, [text](link), *emphasis*.
std::string Plain(std::string_view cell) {
  while (cell.starts_with(' ')) cell.remove_prefix(1);
  while (cell.ends_with(' ')) cell.remove_suffix(1);
  std::string out;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    if (cell[i] == '`' || cell[i] == '*') continue;
    const std::size_t end = cell[i] == '[' ? cell.find(']', i) : std::string_view::npos;
    const bool link = end != std::string_view::npos && cell.substr(end).starts_with("](");
    if (!link) {
      out += cell[i];
      continue;
    }
    out += Plain(cell.substr(i + 1, end - i - 1));
    i = std::min(cell.find(')', end), cell.size());
  }
  return out;
}

}  // namespace

CounterWords WordsOf(std::string_view counter) {
  CounterWords words;
  const std::string_view page = OperatingPage();
  const std::size_t section = page.find("\n## Counters\n");
  const std::string key = "\n| `" + std::string(counter) + "` |";
  const std::size_t at = section == std::string_view::npos ? section : page.find(key, section);
  if (at == std::string_view::npos) return words;
  std::string_view rest = page.substr(at + key.size());
  rest = rest.substr(0, rest.find('\n'));
  std::array<std::string, 4> cells;  // meaning, bad, logged, what to do
  for (std::string& cell : cells) {
    const std::size_t end = rest.find('|');
    if (end == std::string_view::npos) return words;
    cell = Plain(rest.substr(0, end));
    rest.remove_prefix(end + 1);
  }
  words.known = true;
  words.meaning = cells[0];
  words.always = cells[1] == "yes";
  words.trouble = cells[2] == "yes";
  words.change = cells[3];
  return words;
}

}  // namespace styled::doctor
