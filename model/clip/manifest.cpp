#include "model/clip/manifest.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <tuple>

#include "model/base/read_file.h"
#include "model/base/toml_nesting.h"

namespace styled::clip {
namespace {

constexpr std::string_view kTake = "{take}";

namespace fs = std::filesystem;

constexpr std::size_t kMaxManifestBytes = std::size_t{1} << 20;  // our longest has 20 kB
constexpr std::size_t kLongestPattern = 1000;
constexpr int kMostMistakes = 20;  // [[clips]] that are reported at once

// A label in file names and the name that it stands for.
struct Label {
  std::string label, name;
};

struct Values {
  std::string style, content;  // by name, not by label
  int take = 0;
};

// One [[clips]] table.
struct Rule {
  std::string pattern, style, content, rig = "auto", split = "train";
  double judge_share = 0, validation_share = 0, test_share = 0;
  double from = 0, to = 1, repeat_s = 0, skip_s = 0;
  bool floor_at_feet = false, still = true;
  std::string person;
  std::vector<std::string> except;  // patterns of files to leave out
};

// Matches one relative path against a pattern. Backtracks over labels, digits and '*'. Remembers
// failed positions, because a pattern with many stars would otherwise take exponential time.
class Matcher {
 public:
  Matcher(const std::vector<Label>& styles, const std::vector<Label>& contents)
      : styles_(styles), contents_(contents) {}

  std::optional<Values> Match(std::string_view pattern, std::string_view text) {
    failed_.assign((pattern.size() + 1) * (text.size() + 1), false);
    width_ = text.size() + 1;
    Values values;
    if (!Step(pattern, text, values)) return std::nullopt;
    return values;
  }

 private:
  // `pattern` and `text` are the remaining parts.
  bool Step(std::string_view pattern, std::string_view text, Values& values) {
    const std::size_t place = pattern.size() * width_ + text.size();
    if (failed_[place]) return false;
    const bool matches = Try(pattern, text, values);
    failed_[place] = !matches;
    return matches;
  }

  bool Try(std::string_view pattern, std::string_view text, Values& values) {
    if (pattern.empty()) return text.empty();
    if (pattern.starts_with("{style}")) {
      return Labels(styles_, pattern.substr(7), text, values, values.style);
    }
    if (pattern.starts_with("{content}")) {
      return Labels(contents_, pattern.substr(9), text, values, values.content);
    }
    if (pattern.starts_with(kTake)) {
      std::size_t digits = 0;
      while (digits < text.size() && digits < 9 && text[digits] >= '0' && text[digits] <= '9') {
        ++digits;
      }
      for (; digits > 0; --digits) {
        if (!Step(pattern.substr(6), text.substr(digits), values)) continue;
        values.take = std::stoi(std::string(text.substr(0, digits)));
        return true;
      }
      return false;
    }
    if (pattern[0] == '*') {
      for (std::size_t skip = 0;; ++skip) {
        if (Step(pattern.substr(1), text.substr(skip), values)) return true;
        if (skip == text.size() || text[skip] == '/') return false;
      }
    }
    return !text.empty() && text[0] == pattern[0] &&
           Step(pattern.substr(1), text.substr(1), values);
  }

  // Tries each label; the labels are sorted longest first.
  bool Labels(const std::vector<Label>& labels, std::string_view rest, std::string_view text,
              Values& values, std::string& found) {
    for (const Label& label : labels) {
      if (!text.starts_with(label.label)) continue;
      if (!Step(rest, text.substr(label.label.size()), values)) continue;
      found = label.name;
      return true;
    }
    return false;
  }

  const std::vector<Label>& styles_;
  const std::vector<Label>& contents_;
  std::vector<bool> failed_;  // by the remaining lengths of pattern and text
  std::size_t width_ = 0;
};

class Loader {
 public:
  Loader(const fs::path& file, const fs::path& data_folder) : file_(file), data_(data_folder) {}

  Result<Manifest> Run() {
    const auto text = styled::ReadFile(file_.string(), kMaxManifestBytes);
    if (!text.ok()) return text.status();
    if (const auto line = FindTooDeepToml(text.value())) {
      return Status::Error(file_.string() + ":" + std::to_string(*line) + ": " + TooDeepToml());
    }
    toml::table root;
    try {
      root = toml::parse(text.value(), file_.string());
    } catch (const toml::parse_error& error) {
      return Status::Error(file_.string() + ":" + std::to_string(error.source().begin.line) +
                           ": found " + std::string(error.description()) + ", expected TOML");
    }
    // Each part names its first mistake. [still] and [[clips]] refer to the parts before them.
    const bool head = Head(root), styles = Styles(root), contents = Contents(root);
    if (!(head && styles && contents && Still(root)) || !Clips(root)) return Status::Error(error_);
    std::sort(manifest_.entries.begin(), manifest_.entries.end(),
              [](const ManifestEntry& a, const ManifestEntry& b) {
                return std::tie(a.file, a.from) < std::tie(b.file, b.from);
              });
    for (std::size_t i = 1; i < manifest_.entries.size(); ++i) {
      const ManifestEntry& before = manifest_.entries[i - 1];
      const ManifestEntry& entry = manifest_.entries[i];
      if (entry.file == before.file && entry.from < before.to) {
        return Status::Error(file_.string() + ": found " + entry.file.string() +
                             " under two patterns, expected each part of a clip once");
      }
    }
    return std::move(manifest_);
  }

 private:
  bool Fail(const toml::node& at, const std::string& key, const std::string& found,
            const std::string& expected) {
    error_ += (error_.empty() ? "" : "\n") + file_.string() + ":" +
              std::to_string(at.source().begin.line) + ": " + key + ": found " + found +
              ", expected " + expected;
    return false;
  }
  bool OnlyKeys(const toml::table& table, std::initializer_list<std::string_view> known) {
    for (const auto& [key, node] : table) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      std::string names;
      for (std::string_view name : known) names += (names.empty() ? "" : ", ") + std::string(name);
      return Fail(node, std::string(key.str()), "an unknown key", "one of " + names);
    }
    return true;
  }
  // Leaves `out` unchanged if the key is missing and not required.
  bool String(const toml::table& table, std::string_view key, bool required, std::string& out) {
    const toml::node* node = table.get(key);
    if (node == nullptr) {
      return !required || Fail(table, std::string(key), "nothing", "a string");
    }
    const auto* value = node->as_string();
    if (value == nullptr || value->get().empty()) {
      return Fail(*node, std::string(key), "something else", "a string that is not empty");
    }
    out = value->get();
    return true;
  }
  bool Strings(const toml::table& table, std::string_view key, bool required,
               std::vector<std::string>& out) {
    const toml::node* node = table.get(key);
    if (node == nullptr) {
      return !required || Fail(table, std::string(key), "nothing", "an array of strings");
    }
    const toml::array* array = node->as_array();
    if (array == nullptr || (required && array->empty())) {
      return Fail(*node, std::string(key), array == nullptr ? "something else" : "an empty array",
                  "an array of strings");
    }
    for (const toml::node& item : *array) {
      const auto* value = item.as_string();
      if (value == nullptr || value->get().empty()) {
        return Fail(item, std::string(key), "something else in the array",
                    "strings that are not empty");
      }
      out.push_back(value->get());
    }
    return true;
  }
  // The array of tables under `key`; it must not be empty.
  const toml::array* Tables(const toml::table& root, std::string_view key) {
    const toml::node* node = root.get(key);
    const toml::array* array = node == nullptr ? nullptr : node->as_array();
    if (array != nullptr && !array->empty() && array->is_homogeneous(toml::node_type::table)) {
      return array;
    }
    Fail(node == nullptr ? static_cast<const toml::node&>(root) : *node, std::string(key),
         node == nullptr ? "nothing" : "something else", "an array of tables, at least one");
    return nullptr;
  }
  bool AddLabels(const toml::node& at, const std::string& key, const std::string& name,
                 const std::vector<std::string>& names, std::vector<Label>& labels) {
    for (const std::string& label : names) {
      for (const Label& known : labels) {
        if (known.label == label) {
          return Fail(at, key, "label \"" + label + "\" twice", "each label once");
        }
      }
      labels.push_back({label, name});
    }
    return true;
  }
  static void LongestFirst(std::vector<Label>& labels) {
    std::stable_sort(labels.begin(), labels.end(), [](const Label& a, const Label& b) {
      return a.label.size() > b.label.size();
    });
  }

  bool Head(const toml::table& root) {
    return OnlyKeys(root, {"name", "licence", "neutral", "styles", "contents", "still", "clips"}) &&
           String(root, "name", true, manifest_.name) &&
           String(root, "licence", true, manifest_.licence) &&
           String(root, "neutral", true, neutral_);
  }

  bool Styles(const toml::table& root) {
    const toml::array* styles = Tables(root, "styles");
    if (styles == nullptr) return false;
    for (const toml::node& node : *styles) {
      const toml::table& table = *node.as_table();
      ManifestStyle style;
      if (!OnlyKeys(table, {"name", "labels", "aliases", "licence", "credit"}) ||
          !String(table, "name", true, style.name) ||
          !String(table, "licence", false, style.licence) ||
          !String(table, "credit", false, style.credit) ||
          !Strings(table, "labels", true, style.labels) ||
          !Strings(table, "aliases", false, style.aliases) ||
          !AddLabels(node, "styles", style.name, style.labels, styles_)) {
        return false;
      }
      for (const ManifestStyle& known : manifest_.styles) {
        if (known.name == style.name) {
          return Fail(node, "styles", "\"" + style.name + "\" twice", "each style once");
        }
      }
      manifest_.styles.push_back(std::move(style));
    }
    if (manifest_.styles[0].name != neutral_) {
      return Fail(*styles, "styles", "\"" + manifest_.styles[0].name + "\" first",
                  "the neutral style \"" + neutral_ + "\" first");
    }
    LongestFirst(styles_);
    return true;
  }

  bool Contents(const toml::table& root) {
    const toml::array* contents = Tables(root, "contents");
    if (contents == nullptr) return false;
    for (const toml::node& node : *contents) {
      const toml::table& table = *node.as_table();
      std::string name;
      std::vector<std::string> labels;
      if (!OnlyKeys(table, {"name", "labels"}) || !String(table, "name", true, name) ||
          !Strings(table, "labels", false, labels) ||
          !AddLabels(node, "contents", name, labels, contents_)) {
        return false;
      }
      if (std::find(manifest_.contents.begin(), manifest_.contents.end(), name) !=
          manifest_.contents.end()) {
        return Fail(node, "contents", "\"" + name + "\" twice", "each content once");
      }
      manifest_.contents.push_back(std::move(name));
      manifest_.content_labels.push_back(std::max<std::size_t>(labels.size(), 1));
    }
    LongestFirst(contents_);
    return true;
  }

  // Reads a number of at least `low`. Leaves `out` unchanged if the key is missing.
  bool Number(const toml::table& table, std::string_view key, double low, double& out) {
    const toml::node* node = table.get(key);
    if (node == nullptr) return true;
    const auto value = node->value<double>();
    if (!value || !(*value >= low)) {
      return Fail(*node, std::string(key), value ? std::to_string(*value) : "something else",
                  "a number from " + std::to_string(low) + " up");
    }
    out = *value;
    return true;
  }

  bool Still(const toml::table& root) {
    const toml::node* node = root.get("still");
    if (node == nullptr) return true;
    const toml::table* table = node->as_table();
    if (table == nullptr) return Fail(*node, "still", "something else", "a table");
    if (!OnlyKeys(*table, {"content", "speed_mps"}) ||
        !String(*table, "content", true, manifest_.still_content) ||
        !Number(*table, "speed_mps", 0, manifest_.still_speed_mps)) {
      return false;
    }
    if (std::find(manifest_.contents.begin(), manifest_.contents.end(), manifest_.still_content) ==
        manifest_.contents.end()) {
      return Fail(*node, "content", "\"" + manifest_.still_content + "\"",
                  "the name of one of the contents");
    }
    if (!(manifest_.still_speed_mps > 0)) {
      return Fail(*node, "speed_mps", "nothing", "a number above 0");
    }
    return true;
  }

  bool Clips(const toml::table& root) {
    const toml::array* clips = Tables(root, "clips");
    if (clips == nullptr) return false;
    int wrong = 0;
    for (const toml::node& node : *clips) {
      Rule rule;
      if (ReadRule(*node.as_table(), rule) && Collect(node, rule)) continue;
      if (++wrong == kMostMistakes) break;
    }
    return wrong == 0;
  }

  bool ReadRule(const toml::table& table, Rule& rule) {
    if (!OnlyKeys(table, {"pattern", "style", "content", "rig", "split", "judge_share",
                          "validation_share", "test_share", "time", "repeat_s", "skip_s", "floor",
                          "still", "person", "except"}) ||
        !String(table, "pattern", true, rule.pattern) ||
        !String(table, "style", false, rule.style) ||
        !String(table, "content", false, rule.content) || !String(table, "rig", false, rule.rig) ||
        !String(table, "split", false, rule.split) ||
        !String(table, "person", false, rule.person) ||
        !Number(table, "repeat_s", 0, rule.repeat_s) || !Number(table, "skip_s", 0, rule.skip_s) ||
        !Time(table, rule) || !Floor(table, rule) || !Truth(table, "still", rule.still) ||
        !Strings(table, "except", false, rule.except)) {
      return false;
    }
    const auto too_long = [](const std::string& pattern) {
      return pattern.size() > kLongestPattern;
    };
    if (too_long(rule.pattern) || std::ranges::any_of(rule.except, too_long)) {
      return Fail(table, "pattern", "one that is longer",
                  "at most " + std::to_string(kLongestPattern) + " characters");
    }
    for (const auto& [key, fixed] : {std::pair{"style", &rule.style}, {"content", &rule.content}}) {
      const bool in_pattern = rule.pattern.find("{" + std::string(key) + "}") != std::string::npos;
      if (in_pattern != fixed->empty()) {
        return Fail(table, key, in_pattern ? "it fixed and in the pattern" : "nothing",
                    "it either fixed or as {" + std::string(key) + "} in the pattern");
      }
    }
    const auto names = [](const auto& list, const std::string& name, auto member) {
      return std::any_of(list.begin(), list.end(),
                         [&](const auto& item) { return member(item) == name; });
    };
    if (!rule.style.empty() &&
        !names(manifest_.styles, rule.style, [](const ManifestStyle& s) { return s.name; })) {
      return Fail(table, "style", "\"" + rule.style + "\"", "the name of one of the styles");
    }
    if (!rule.content.empty() &&
        !names(manifest_.contents, rule.content, [](const std::string& s) { return s; })) {
      return Fail(table, "content", "\"" + rule.content + "\"", "the name of one of the contents");
    }
    if (rule.split != "train" && rule.split != "judge" && rule.split != "validation" &&
        rule.split != "test") {
      return Fail(table, "split", "\"" + rule.split + "\"", "train, judge, validation or test");
    }
    if (!Share(table, "judge_share", rule.split, "train", rule.judge_share) ||
        !Share(table, "validation_share", rule.split, "train", rule.validation_share) ||
        !Share(table, "test_share", rule.split, "validation", rule.test_share)) {
      return false;
    }
    return rule.judge_share + rule.validation_share < 1 ||
           Fail(table, "judge_share", "it and validation_share with a sum of 1 or more",
                "a part that is left for training");
  }

  // The share of a rule's clips that goes from the split `of` to another one. Leaves `out`
  // unchanged if the key is missing.
  bool Share(const toml::table& table, std::string_view key, const std::string& split,
             const std::string& of, double& out) {
    const toml::node* node = table.get(key);
    if (node == nullptr) return true;
    const auto share = node->value<double>();
    if (!share || !(*share >= 0 && *share < 1)) {
      return Fail(*node, std::string(key), share ? std::to_string(*share) : "something else",
                  "a number from 0 to below 1");
    }
    if (split != of) {
      return Fail(*node, std::string(key), "it with split \"" + split + "\"",
                  "it with split \"" + of + "\" only");
    }
    out = *share;
    return true;
  }

  // Leaves `out` unchanged if the key is missing.
  bool Truth(const toml::table& table, std::string_view key, bool& out) {
    const toml::node* node = table.get(key);
    if (node == nullptr) return true;
    const auto value = node->value_exact<bool>();
    if (!value) return Fail(*node, std::string(key), "something else", "true or false");
    out = *value;
    return true;
  }

  bool Floor(const toml::table& table, Rule& rule) {
    std::string floor;
    if (!String(table, "floor", false, floor)) return false;
    if (!floor.empty() && floor != "feet") {
      return Fail(*table.get("floor"), "floor", "\"" + floor + "\"",
                  "\"feet\", or nothing where the file's own floor is right");
    }
    rule.floor_at_feet = !floor.empty();
    return true;
  }

  bool Time(const toml::table& table, Rule& rule) {
    const toml::node* node = table.get("time");
    if (node == nullptr) return true;
    const toml::array* array = node->as_array();
    const bool pair = array != nullptr && array->size() == 2;
    const auto from = pair ? (*array)[0].value<double>() : std::nullopt;
    const auto to = pair ? (*array)[1].value<double>() : std::nullopt;
    if (!from || !to || !(*from >= 0 && *from < *to && *to <= 1)) {
      return Fail(*node, "time", "something else", "[from, to] with 0 <= from < to <= 1");
    }
    rule.from = *from;
    rule.to = *to;
    return true;
  }

  bool Collect(const toml::node& at, const Rule& rule) {
    // Start at the folder of the first path component that is not a plain name.
    const std::size_t plain = rule.pattern.substr(0, rule.pattern.find_first_of("{*")).rfind('/');
    const fs::path folder =
        plain == std::string::npos ? data_ : data_ / rule.pattern.substr(0, plain);
    const std::size_t first = manifest_.entries.size();
    Matcher matcher(styles_, contents_);
    std::error_code code;
    fs::recursive_directory_iterator walk(folder, code);
    for (; !code && walk != fs::recursive_directory_iterator(); walk.increment(code)) {
      std::error_code ignored;
      if (!walk->is_regular_file(ignored)) continue;
      const std::string path = walk->path().lexically_relative(data_).generic_string();
      const std::optional<Values> values = matcher.Match(rule.pattern, path);
      if (!values || std::any_of(rule.except.begin(), rule.except.end(), [&](const auto& except) {
            return matcher.Match(except, path).has_value();
          })) {
        continue;
      }
      std::string person = rule.person;
      if (const std::size_t take = person.find(kTake); take != std::string::npos) {
        person.replace(take, kTake.size(), std::to_string(values->take));
      }
      manifest_.entries.push_back({walk->path(), rule.style.empty() ? values->style : rule.style,
                                   rule.content.empty() ? values->content : rule.content, rule.rig,
                                   rule.split, values->take, rule.from, rule.to, rule.repeat_s,
                                   rule.skip_s, rule.floor_at_feet, rule.still, std::move(person)});
    }
    if (manifest_.entries.size() == first) {
      return Fail(at, "pattern", "no file for \"" + rule.pattern + "\" in " + data_.string(),
                  "at least one");
    }
    SetAside(first, rule);
    return true;
  }

  // Assigns the last takes of every (style, content) cell to the test or the validation, those
  // before them to the judge; at least one clip stays in each.
  void SetAside(std::size_t first, const Rule& rule) {
    if (rule.judge_share <= 0 && rule.validation_share <= 0 && rule.test_share <= 0) return;
    std::map<std::tuple<std::string, std::string>, std::vector<ManifestEntry*>> cells;
    for (std::size_t i = first; i < manifest_.entries.size(); ++i) {
      ManifestEntry& entry = manifest_.entries[i];
      cells[{entry.style, entry.content}].push_back(&entry);
    }
    for (auto& [cell, entries] : cells) {
      std::sort(entries.begin(), entries.end(), [](const ManifestEntry* a, const ManifestEntry* b) {
        return std::tie(a->take, a->file) < std::tie(b->take, b->file);
      });
      const auto count = static_cast<double>(entries.size());
      std::size_t left = entries.size();
      for (const auto& [split, share] : {std::pair{"test", rule.test_share},
                                         {"validation", rule.validation_share},
                                         {"judge", rule.judge_share}}) {
        const auto wanted = static_cast<std::size_t>(std::lround(share * count));
        for (const std::size_t end = left - std::min(wanted, left - 1); left > end; --left) {
          entries[left - 1]->split = split;
        }
      }
    }
  }

  const fs::path& file_;
  const fs::path& data_;
  std::string neutral_;
  std::vector<Label> styles_, contents_;
  Manifest manifest_;
  std::string error_;
};

}  // namespace

Result<Manifest> LoadManifest(const fs::path& file, const fs::path& data_folder) {
  return Loader(file, data_folder).Run();
}

}  // namespace styled::clip
