#include "daemon/pipeline/keeping.h"

#include <fcntl.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "daemon/runtime/descriptor.h"

namespace styled::pipeline {
namespace {

toml::table Row(const Profile& profile) {
  toml::array mix;
  for (const auto& [style, weight] : profile.look.mix) {
    mix.push_back(toml::table{{"style", style}, {"weight", static_cast<double>(weight)}});
  }
  return toml::table{{"mix", std::move(mix)},
                     {"strength", static_cast<double>(profile.look.strength)},
                     {"transition_s", static_cast<double>(profile.look.transition_s)},
                     {"absolute", profile.look.absolute},
                     {"only", body::PartsText(profile.look.parts)},
                     {"own_style", profile.look.own_style},
                     {"preset", profile.look.preset},
                     {"pinned", profile.pinned}};
}

Profile FromRow(std::string_view id, const toml::table& row) {
  Profile profile;
  profile.id = id;
  profile.configured = true;
  profile.look.strength = row["strength"].value_or(1.0F);
  profile.look.transition_s = row["transition_s"].value_or(0.4F);
  profile.look.absolute = row["absolute"].value_or(false);
  profile.look.parts =
      body::FindParts(row["only"].value_or(std::string("all"))).value_or(body::kAllParts);
  profile.look.own_style = row["own_style"].value_or(std::string());
  profile.look.preset = row["preset"].value_or(std::string());
  profile.pinned = row["pinned"].value_or(false);
  if (const toml::array* mix = row["mix"].as_array()) {
    for (const auto& entry : *mix) {
      const toml::table* pair = entry.as_table();
      if (pair == nullptr) continue;
      profile.look.mix.emplace_back((*pair)["style"].value_or(std::string()),
                                    (*pair)["weight"].value_or(0.0F));
    }
  }
  return profile;
}

}  // namespace

Status WriteProfiles(const std::string& file, const std::vector<Profile>& profiles) {
  toml::table table;
  for (const auto& profile : profiles) table.insert_or_assign(profile.id, Row(profile));
  std::ostringstream text;
  text << "# Written by styled: the settings of its performers.\n" << table << "\n";
  const std::string bytes = text.str();
  const std::string fresh = file + ".new";
  const auto refuse = [&fresh] { return Status::Error(fresh + ": " + std::strerror(errno)); };
  const runtime::Descriptor out(
      open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (out.get() < 0) return refuse();
  if (write(out.get(), bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()) ||
      fsync(out.get()) != 0 || rename(fresh.c_str(), file.c_str()) != 0) {
    return refuse();
  }
  return Status::Ok();
}

Result<std::vector<Profile>> ReadProfiles(const std::string& file) {
  std::vector<Profile> profiles;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return profiles;
  try {
    const toml::table table = toml::parse_file(file);
    for (const auto& [id, node] : table) {
      if (const toml::table* row = node.as_table()) profiles.push_back(FromRow(id.str(), *row));
    }
  } catch (const toml::parse_error& broken) {
    return Status::Error(file + ":" + std::to_string(broken.source().begin.line) + ": " +
                         std::string(broken.description()));
  }
  return profiles;
}

}  // namespace styled::pipeline
