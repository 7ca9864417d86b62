// design: a style by hand.
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/stylectl/cli.h"
#include "clients/stylectl/commands.h"
#include "clients/stylectl/like_report.h"
#include "clients/stylectl/report.h"
#include "model/base/text.h"
#include "model/tools/number.h"

namespace styled::stylectl {
namespace {

struct DesignArguments {
  std::vector<std::string> sliders;  // NAME=VALUE
  std::string name, from, preset;
  std::optional<double> transition_ms;
  bool list = false;
};

std::string SlidersText(const v1::ListReply& list) {
  if (list.sliders().empty()) {
    return "these weights have no sliders; expected weights with a file of the family phase "
           "([model] gaits)\n";
  }
  std::vector<std::vector<std::string>> rows{{"SLIDER", "FROM", "TO", "USUAL", "UNIT", ""}};
  for (const v1::SliderInfo& slider : list.sliders()) {
    rows.push_back({slider.name(), NumberText(slider.least(), 1), NumberText(slider.most(), 1),
                    NumberText(slider.usual(), 1), slider.unit(), slider.what()});
  }
  std::string text = Table(rows) + "\n";
  rows = {{"DESIGN", "SLIDERS"}};
  for (const v1::DesignInfo& design : list.designs()) {
    // In the map's order, which differs from call to call, no list could be compared.
    const std::map<std::string, float> sliders(design.sliders().begin(), design.sliders().end());
    std::string values;
    for (const auto& [name, value] : sliders) {
      values += (values.empty() ? "" : " ") + name + "=" + NumberText(value, 2);
    }
    rows.push_back({design.name(), values});
  }
  return text + Table(rows);
}

int ListSliders(Session& session) {
  v1::ListReply list;
  if (const auto status = session.control().List(&list); !status.ok()) return session.Fail(status);
  session.out << SlidersText(list);
  return kExitOk;
}

// "stoop=28" into the request; false if it is not one.
bool SetSlider(const std::string& text, v1::Design& design) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) return false;
  double value = 0;
  if (!CLI::detail::lexical_cast(text.substr(equals + 1), value) || !std::isfinite(value)) {
    return false;
  }
  (*design.mutable_sliders())[text.substr(0, equals)] = static_cast<float>(value);
  return true;
}

// A style by hand is of one performer: the only one that is live, where none is named. Else a usage
// error.
int ChoosePerformer(Session& session) {
  v1::StatusReply status;
  const client::CallStatus asked = session.control().Status(&status);
  if (!asked.ok()) return session.Fail(asked);
  std::vector<std::string> live;
  for (const auto& performer : status.stats().performers()) {
    if (performer.live()) live.push_back(performer.performer());
  }
  if (live.size() == 1) {
    session.performer = live.front();
    return kExitOk;
  }
  std::string here = live.empty() ? "no performer is live" : "here are:";
  for (const std::string& name : live) here += " " + name;
  return session.Usage("design: a style by hand is of one performer, expected SOURCE.NAME; " +
                       here);
}

int DesignStyle(Session& session, const DesignArguments& arguments) {
  if (arguments.list) return ListSliders(session);
  if (session.performer == client::kEveryone) {
    if (const int code = ChoosePerformer(session); code != kExitOk) return code;
  }
  v1::Like request;
  v1::Design& design = *request.mutable_design();
  for (const std::string& slider : arguments.sliders) {
    if (!SetSlider(slider, design)) {
      return session.Usage("design: \"" + slider +
                           "\": expected SLIDER=NUMBER, e.g. stoop=28, or a design after --preset; "
                           "stylectl design --list");
    }
  }
  request.set_name(arguments.name);
  design.set_from(arguments.from);
  design.set_preset(arguments.preset);
  if (arguments.transition_ms) {
    request.set_transition_ms(static_cast<float>(*arguments.transition_ms));
  }
  return MakeStyle(session, session.performer, request);
}

}  // namespace

void DeclareDesign(Session& session) {
  const auto arguments = std::make_shared<DesignArguments>();
  CLI::App* design =
      session.AddOnline("design", "make a style by hand, and set a performer to it",
                        [&session, arguments] { return DesignStyle(session, *arguments); });
  session.AddPerformer(design, false, true);
  design->add_option("SLIDERS", arguments->sliders,
                     "SLIDER=NUMBER ..., e.g. stoop=28 elbows=55 energy=0.6; the others keep their "
                     "value");
  design->add_option("--name", arguments->name,
                     "name of the style, for all clients; one that was made by hand is changed "
                     "(default: by-hand-PERFORMER)");
  design->add_option("--from", arguments->from,
                     "begin with this style: of weights with sliders, or made from an example");
  design->add_option("--preset", arguments->preset,
                     "begin with this design: sneaky, drunk, robot, proud, scared, cold, neutral");
  design->add_option("--transition", arguments->transition_ms, "fade, ms")
      ->check(Number(0.0, 60000.0));
  design->add_flag("--list", arguments->list, "only show the sliders and designs that there are");
}

}  // namespace styled::stylectl
