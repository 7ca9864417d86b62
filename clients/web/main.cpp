// styleweb: a gateway between the daemon and browsers. 0: clean stop. 1: could not run. 2: usage.
#include <google/protobuf/stubs/logging.h>

#include <CLI/CLI.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "clients/web/gateway.h"
#include "model/base/version.h"

namespace {

constexpr int kFailed = 1, kUsage = 2;

struct Arguments {
  styled::web::Options options;
  std::string ready_file;
};

void Declare(CLI::App& app, Arguments& arguments) {
  styled::web::Options& o = arguments.options;
  app.add_option("--listen", o.listen, "HOST:PORT; port 0: any free one")->capture_default_str();
  app.add_option("--publish,--publisher", o.publish, "the daemon's publisher")
      ->envname("STYLED_PUBLISHER")
      ->capture_default_str();
  app.add_option("--control", o.control, "the daemon's control socket")
      ->envname("STYLED_CONTROL")
      ->capture_default_str();
  styled::client::Declare(app, o.keys);
  app.add_option("--page", o.page, "folder of the built page; default: beside the program");
  app.add_option(
      "--token-file", o.token_file,
      "file whose first line is the token that all requests except for the page need: ?token=... "
      "or "
      "Authorization: Bearer ...; needed on other addresses than loopback; refused where others "
      "can read it");
  app.add_flag("--allow-unauthenticated-remote", o.allow_unauthenticated_remote,
               "no token although others can reach the address: everyone may watch and control");
  app.add_option("--origin", o.origins,
                 "a page of another site that may connect, e.g. http://stage.lan:5173; again for "
                 "more")
      ->allow_extra_args(false);
  app.add_option(
         "--host", o.hosts,
         "a further name by which browsers may call this machine, e.g. stage.lan; again for "
         "more; needed where there is no token")
      ->allow_extra_args(false);
  app.add_flag("--watch-only", o.watch_only, "browsers may not change anything");
  app.add_option(
         "--max-connections", o.max_connections,
         "maximum number of connections; a further one closes the oldest that has not finished its "
         "request, or is closed itself if there is none")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--ready-file", arguments.ready_file,
                 "where to write the address, as JSON, once it listens");
  app.set_version_flag("--version", styled::VersionText("styleweb"));
  app.footer("Exit codes: 0 stopped by a signal, 1 could not run, 2 usage.");
}

// Writes atomically: a program that waits for the file must not read half of it.
bool WriteReady(const std::string& file, const std::string& address) {
  const std::string part = file + ".part";
  std::ofstream(part) << nlohmann::json{{"listen", address}} << "\n";
  std::error_code error;
  std::filesystem::rename(part, file, error);
  return !error;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"styleweb: shows and controls styled in browsers", "styleweb"};
  Declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : kUsage;
  }
  google::protobuf::SetLogHandler(nullptr);  // unparseable messages are counted
  std::signal(SIGPIPE, SIG_IGN);
  try {
    boost::asio::io_context io(1);
    boost::asio::signal_set signals(io, SIGINT, SIGTERM);
    signals.async_wait([&io](const boost::system::error_code&, int) { io.stop(); });
    auto gateway = styled::web::Gateway::Start(io, arguments.options);
    if (!gateway.ok()) {
      std::cerr << "styleweb: " << gateway.status().message() << "\n";
      return kUsage;
    }
    const std::string& address = gateway.value()->address();
    std::cout << "styleweb: " << address << (gateway.value()->page.empty() ? " (no page)" : "")
              << std::endl;
    if (!arguments.ready_file.empty() && !WriteReady(arguments.ready_file, address)) {
      std::cerr << "styleweb: --ready-file " << arguments.ready_file << ": cannot write it\n";
      return kFailed;
    }
    io.run();
  } catch (const std::exception& error) {
    std::cerr << "styleweb: " << error.what() << "\n";
    return kFailed;
  }
  return 0;
}
