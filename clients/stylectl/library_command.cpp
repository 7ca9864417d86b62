// styles: the made styles, their files and their names.
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

constexpr std::size_t kMaxStyleFileBytes = std::size_t{1} << 20U;  // as the daemon reads at most

struct LibraryArguments {
  std::string name, to, file;
  bool replace = false, overwrite = false;
};

int ReportDone(Session& session, const std::string& text, nlohmann::json object) {
  object["ok"] = true;
  if (session.json) {
    session.out << object.dump() << "\n";
  } else {
    session.out << text << "\n";
  }
  return kExitOk;
}

int ListMade(Session& session) {
  v1::ListReply list;
  if (const auto status = session.control().List(&list); !status.ok()) return session.Fail(status);
  if (session.json) return ReportDone(session, "", {{"styles", ListJson(list)["styles"]}});
  session.out << StylesText(list);
  return kExitOk;
}

int ExportStyle(Session& session, const LibraryArguments& arguments) {
  session.styles.push_back(arguments.name);
  const auto taken = [&](const std::string& file) {
    return file != "-" && !arguments.overwrite && std::filesystem::exists(file);
  };
  const auto refuse = [&session](const std::string& file) {
    return session.Usage("styles export: " + file +
                         ": exists, expected a new file; --overwrite replaces it");
  };
  if (!arguments.file.empty() && taken(arguments.file)) return refuse(arguments.file);
  v1::StyleFile style;
  if (const auto status = session.control().ExportStyle(arguments.name, &style); !status.ok()) {
    return session.Fail(status);
  }
  const std::string file = arguments.file.empty() ? style.name() + ".json" : arguments.file;
  if (taken(file)) return refuse(file);
  if (file == "-") {
    session.raw << style.file();
    return kExitOk;
  }
  const styled::Status written = WriteFileAtomically(file, style.file(), 0644);
  if (!written.ok()) return session.Usage("styles export: " + written.message());
  return ReportDone(session, "style " + style.name() + " written to " + file,
                    {{"style", style.name()}, {"file", file}});
}

int ImportStyle(Session& session, const LibraryArguments& arguments) {
  auto text = ReadFile(arguments.file, kMaxStyleFileBytes);
  if (!text.ok()) return session.Usage("styles import: " + text.status().message());
  v1::ImportStyle wanted;
  wanted.set_file(std::move(text.value()));
  wanted.set_name(arguments.name);
  wanted.set_replace(arguments.replace);
  v1::LikeReply reply;
  if (const auto status = session.control().ImportStyle(wanted, &reply); !status.ok()) {
    return session.Fail(status);
  }
  return ReportDone(session,
                    "style " + reply.name() + ": nearest to " + reply.nearest() + ", at " +
                        NumberText(reply.distance(), 2) + " of the mean distance between styles",
                    {{"style", reply.name()},
                     {"nearest", reply.nearest()},
                     {"distance", reply.distance()},
                     {"seconds", reply.seconds()}});
}

int RenameStyle(Session& session, const LibraryArguments& arguments) {
  session.styles.push_back(arguments.name);
  client::Applied applied;
  const auto status = session.control().RenameStyle(arguments.name, arguments.to, &applied);
  if (!status.ok()) return session.Fail(status);
  return ReportDone(session, "style " + arguments.name + " is called " + arguments.to + " now",
                    {{"style", arguments.to}, {"applied", AppliedJson(applied)}});
}

int RemoveStyle(Session& session, const LibraryArguments& arguments) {
  session.styles.push_back(arguments.name);
  client::Applied applied;
  const auto status = session.control().RemoveStyle(arguments.name, &applied);
  if (!status.ok()) return session.Fail(status);
  std::string text = "style " + arguments.name + " removed";
  for (const v1::Applied& one : applied) text += "\n" + one.performer() + ": without it";
  return ReportDone(session, text, {{"style", arguments.name}, {"applied", AppliedJson(applied)}});
}

}  // namespace

void DeclareStyles(Session& session) {
  const auto arguments = std::make_shared<LibraryArguments>();
  CLI::App* styles = session.AddOnline(
      "styles", "the styles: list; export, import, rename, remove made ones",
      [&session] { return session.has_part() ? session.RunPart() : ListMade(session); });
  styles->require_subcommand(0, 1);
  const auto add = [&](const char* name, const char* text, auto run) {
    return session.AddPart(styles, name, text,
                           [&session, arguments, run] { return run(session, *arguments); });
  };
  const auto add_name = [arguments](CLI::App* command) {
    command->add_option("NAME", arguments->name, "name of a made style, as shown by list")
        ->required();
  };
  add("list", "all styles: those of the weights, and made ones with their source",
      [](Session& s, const LibraryArguments&) { return ListMade(s); });
  CLI::App* out = add("export", "write the file of a style that was made",
                      [](Session& s, const LibraryArguments& a) { return ExportStyle(s, a); });
  add_name(out);
  out->add_option("FILE", arguments->file, "to write; - for standard output (default: NAME.json)");
  out->add_flag("--overwrite", arguments->overwrite, "replace a file that exists");
  CLI::App* in = add("import", "add the style of a file, for all clients",
                     [](Session& s, const LibraryArguments& a) { return ImportStyle(s, a); });
  in->add_option("FILE", arguments->file, "a file written by export or the library")->required();
  in->add_option("--name", arguments->name, "name of the style (default: the file's)");
  in->add_flag("--replace", arguments->replace,
               "replace a made style of this name; performers that show it fade over");
  CLI::App* rename = add("rename", "give a style that was made another name",
                         [](Session& s, const LibraryArguments& a) { return RenameStyle(s, a); });
  add_name(rename);
  rename->add_option("TO", arguments->to, "the new name")->required();
  CLI::App* remove =
      add("remove", "remove a style that was made; performers that show it fade to bypass",
          [](Session& s, const LibraryArguments& a) { return RemoveStyle(s, a); });
  add_name(remove);
}

}  // namespace styled::stylectl
