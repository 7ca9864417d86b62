#include "clients/stylectl/key_commands.h"

#include <algorithm>
#include <filesystem>

#include "proto/keys/key_folder.h"

namespace styled::stylectl {
namespace {

// A path that is not a folder contains no information about accepted clients.
Status CheckFolder(const std::string& folder) {
  std::error_code error;
  if (std::filesystem::is_directory(folder, error)) return Status::Ok();
  return Status::Error(folder +
                       " is not a folder; expected the daemon's security.keys: --keys FOLDER or "
                       "STYLED_SECURITY_KEYS (a daemon makes it at its first start)");
}

std::string Padded(std::string text, std::size_t width) {
  text.resize(std::max(text.size(), width), ' ');
  return text;
}

}  // namespace

Result<KeyReport> Keygen(const KeyArguments& arguments) {
  const auto pair = keys::MakePair();
  if (!pair.ok()) return pair.status();
  const Status status = keys::WritePair(arguments.file, pair.value());
  if (!status.ok()) return status;
  const std::string& key = pair.value().public_key;
  return KeyReport{key + "\n", {{"file", arguments.file}, {"publicKey", key}}};
}

Result<KeyReport> AllowKey(const KeyArguments& arguments) {
  if (const Status status = CheckFolder(arguments.folder); !status.ok()) return status;
  keys::Client client{arguments.name, arguments.key,
                      keys::ParseRole(arguments.role).value_or(keys::Role::kSubscriber)};
  std::error_code error;
  if (!keys::IsKey(client.key) && std::filesystem::exists(client.key, error)) {
    auto read = keys::ReadPublicKey(client.key);
    if (!read.ok()) return read.status();
    client.key = std::move(read.value());
  }
  const Status status = keys::Allow(arguments.folder, client);
  if (!status.ok()) return status;
  const std::string role(keys::Name(client.role));
  return KeyReport{client.name + " is allowed as " + role + "\n",
                   {{"name", client.name}, {"role", role}, {"publicKey", client.key}}};
}

Result<KeyReport> RevokeKey(const KeyArguments& arguments) {
  if (const Status status = CheckFolder(arguments.folder); !status.ok()) return status;
  const Status status = keys::Revoke(arguments.folder, arguments.name);
  if (!status.ok()) return status;
  return KeyReport{arguments.name + " is no longer allowed\n", {{"name", arguments.name}}};
}

Result<KeyReport> ListKeys(const KeyArguments& arguments) {
  if (const Status status = CheckFolder(arguments.folder); !status.ok()) return status;
  const auto clients = keys::ReadClients(arguments.folder);
  if (!clients.ok()) return clients.status();
  KeyReport report;
  const auto server = keys::ReadPublicKey(keys::ServerPublicFile(arguments.folder));
  report.object["serverKey"] = server.ok() ? nlohmann::json(server.value()) : nlohmann::json();
  report.text = "daemon: " + (server.ok() ? server.value() : "no pair yet") + "\n\n";
  report.object["clients"] = nlohmann::json::array();
  std::size_t width = 4;
  for (const auto& client : clients.value().allowed) width = std::max(width, client.name.size());
  report.text += Padded("NAME", width) + "  ROLE        PUBLIC KEY\n";
  for (const auto& client : clients.value().allowed) {
    const std::string role(keys::Name(client.role));
    report.text += Padded(client.name, width) + "  " + Padded(role, 10) + "  " + client.key + "\n";
    report.object["clients"].push_back(
        {{"name", client.name}, {"role", role}, {"publicKey", client.key}});
  }
  report.object["complaints"] = clients.value().complaints;
  for (const auto& complaint : clients.value().complaints) {
    report.text += "allows no client: " + complaint + "\n";
  }
  return report;
}

}  // namespace styled::stylectl
