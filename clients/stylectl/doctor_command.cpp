// doctor.
#include "clients/stylectl/commands.h"
#include "clients/stylectl/doctor_report.h"
#include "model/tools/number.h"

namespace styled::stylectl {

void DeclareDoctor(Session& session) {
  const auto options = std::make_shared<doctor::Options>();
  CLI::App* doctor = session.AddOnline(
      "doctor", "connected, but nothing arrives: find the cause", [&session, options] {
        options->endpoint = session.options.endpoint;
        options->endpoint_given = session.app.get_option("--endpoint")->count() > 0;
        options->timeout = session.options.timeout;
        options->curve = session.options.curve;
        return RunDoctor(*options, session.json, session.out, session.err);
      });
  doctor->add_option("--config", options->config, "the daemon's styled.toml");
  doctor->add_option("--source", options->source, "examine only this source");
  doctor->add_option("--seconds", options->seconds, "how long to listen")
      ->check(Number(0.2, 60.0))
      ->capture_default_str();
  doctor->add_option("--listen", options->listen, "TYPE=HOST:PORT: examine this address, too")
      ->allow_extra_args(false);
  doctor->add_flag("!--no-capture", options->capture,
                   "listen only on free ports, even with root's rights");
  doctor->footer("Exit codes: 0 all is well, 1 a problem was found, 2 usage.");
}

}  // namespace styled::stylectl
