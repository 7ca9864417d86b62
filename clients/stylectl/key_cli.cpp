// keygen, allow, revoke, keys: they work on local files; no daemon is contacted.
#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"
#include "clients/stylectl/key_commands.h"

namespace styled::stylectl {
namespace {

using KeyCommand = Result<KeyReport> (*)(const KeyArguments&);

int RunOnKeys(Session& session, KeyArguments& arguments, KeyCommand command) {
  arguments.folder = session.key_folder;
  auto report = command(arguments);
  if (!report.ok()) {
    session.err << "stylectl: " << report.status().message() << "\n";
    if (session.json) {
      session.out << nlohmann::json{{"ok", false},
                                    {"code", "KEYS"},
                                    {"reason", report.status().message()}}
                         .dump()
                  << "\n";
    }
    return kExitRefused;
  }
  report.value().object["ok"] = true;
  session.out << (session.json ? report.value().object.dump() + "\n" : report.value().text);
  return kExitOk;
}

}  // namespace

void DeclareKeyCommands(Session& session) {
  const auto arguments = std::make_shared<KeyArguments>();
  const auto add = [&](const char* name, const char* text, KeyCommand run) {
    return session.Add(name, text,
                       [&session, arguments, run] { return RunOnKeys(session, *arguments, run); });
  };
  add("keygen", "make a pair of keys in a new file, print the public one", Keygen)
      ->add_option("FILE", arguments->file, "the file to create; keep it secret")
      ->required();
  CLI::App* allow = add("allow", "allow a client with this key, effective at once", AllowKey);
  allow->add_option("NAME", arguments->name, "the client's name here: A-Z a-z 0-9 _ -")->required();
  allow->add_option("PUBLICKEY", arguments->key, "as keygen printed it, or a file that holds it")
      ->required();
  allow
      ->add_option("--role", arguments->role,
                   "subscriber: frames; operator: frames and the control socket")
      ->check(CLI::IsMember({"subscriber", "operator"}))
      ->capture_default_str();
  CLI::App* revoke =
      add("revoke", "no longer allow a client; its connections are cut at once", RevokeKey);
  revoke->add_option("NAME", arguments->name, "as shown by keys")->required();
  CLI::App* keys = add("keys", "the daemon's key, and the clients that it allows", ListKeys);
  session.with_key_folder = {allow, revoke, keys};
}

}  // namespace styled::stylectl
