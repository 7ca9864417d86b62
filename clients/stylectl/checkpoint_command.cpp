// checkpoint: a performer's state in a file, and from a file into a daemon.
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"
#include "clients/stylectl/report.h"
#include "model/base/read_file.h"
#include "model/base/text.h"
#include "model/base/write_file.h"

namespace styled::stylectl {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{8} << 20U;  // as the daemon reads at most

struct CheckpointArguments {
  std::string performer, file;
  bool overwrite = false;
};

int WriteToFile(Session& session, const CheckpointArguments& arguments) {
  const auto usage = [&](const std::string& why) {
    return session.Usage("checkpoint take: " + why);
  };
  if (!arguments.overwrite && std::filesystem::exists(arguments.file)) {
    return usage(arguments.file + ": exists, expected a new file; --overwrite replaces it");
  }
  v1::Checkpoint checkpoint;
  const auto status = session.control().TakeCheckpoint(arguments.performer, &checkpoint);
  if (!status.ok()) return session.Fail(status);
  const std::string bytes = checkpoint.SerializeAsString();
  const styled::Status written = WriteFileAtomically(arguments.file, bytes, 0600);
  if (!written.ok()) return usage(written.message());
  if (session.json) {
    session.out << nlohmann::json{{"ok", true},
                                  {"performer", checkpoint.performer()},
                                  {"file", arguments.file},
                                  {"bytes", bytes.size()},
                                  {"sequence", checkpoint.sequence()}}
                       .dump()
                << "\n";
  } else {
    session.out << checkpoint.performer() << " before frame " << checkpoint.sequence()
                << ": written to " << arguments.file << ", " << bytes.size() << " bytes\n";
  }
  return kExitOk;
}

int Restore(Session& session, const CheckpointArguments& arguments) {
  const auto bytes = ReadFile(arguments.file, kMaxBytes);
  if (!bytes.ok()) return session.Usage("checkpoint restore: " + bytes.status().message());
  v1::Checkpoint checkpoint;
  if (!checkpoint.ParseFromString(bytes.value()) || checkpoint.version() == 0) {
    return session.Usage("checkpoint restore: " + arguments.file +
                         ": not a checkpoint, expected a file of stylectl checkpoint take");
  }
  client::Applied applied;
  const auto status =
      session.control().RestoreCheckpoint(arguments.performer, checkpoint, &applied);
  if (!status.ok()) return session.Fail(status);
  if (session.json) {
    session.out << nlohmann::json{{"ok", true}, {"applied", AppliedJson(applied)}}.dump() << "\n";
    return kExitOk;
  }
  for (const v1::Applied& one : applied) {
    session.out << one.performer() << ": restored from frame " << one.first_sequence() << " on\n";
  }
  return kExitOk;
}

}  // namespace

void DeclareLead(Session& session) {
  session.AddOnline("lead", "make a standby the leader; the other daemon becomes its standby",
                    [&session]() -> int {
                      const auto status = session.control().Lead();
                      if (!status.ok()) return session.Fail(status);
                      session.out << (session.json ? "{\"ok\":true}" : "leads") << "\n";
                      return kExitOk;
                    });
}

void DeclareCheckpoints(Session& session) {
  const auto arguments = std::make_shared<CheckpointArguments>();
  CLI::App* checkpoint =
      session.AddOnline("checkpoint", "a performer's whole state: take it to a file, restore it",
                        [&session] { return session.RunPart(); });
  checkpoint->require_subcommand(1);
  CLI::App* take =
      session.AddPart(checkpoint, "take",
                      "write the state of a performer to a file, without affecting the performer",
                      [&session, arguments] { return WriteToFile(session, *arguments); });
  take->add_option("PERFORMER", arguments->performer, "SOURCE.NAME")->required();
  take->add_option("FILE", arguments->file, "to write")->required();
  take->add_flag("--overwrite", arguments->overwrite, "replace a file that exists");
  CLI::App* restore =
      session.AddPart(checkpoint, "restore",
                      "continue a performer from the state in a file, here or on another daemon",
                      [&session, arguments] { return Restore(session, *arguments); });
  restore->add_option("FILE", arguments->file, "of take")->required();
  restore->add_option("PERFORMER", arguments->performer, "SOURCE.NAME (default: the file's)");
}

}  // namespace styled::stylectl
