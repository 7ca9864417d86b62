#include "clients/vmc/find_target.h"

#include <chrono>

#include "clients/cpp/subscriber.h"
#include "clients/oscquery/find.h"
#include "model/base/text.h"

namespace styled::stylevmc {
namespace {

constexpr std::chrono::seconds kSearch(3);

// Why the receiver is not a target; "": it is.
std::string WhyNot(const oscquery::Receiver& receiver, bool vrchat) {
  const std::string name = Printable(receiver.name, 63);
  if (!receiver.trouble.empty()) {
    // VRChat on Windows announces 127.0.0.1 in the network.
    if (receiver.address.starts_with("127.")) {
      return name + " announces the address " + receiver.address + ", but " + receiver.trouble +
             "; it runs on another machine: give that one's address, --to HOST:" +
             std::to_string(receiver.port == 0 ? 9000 : receiver.port);
    }
    return receiver.port == 0 ? name + " does not tell its port: " + receiver.trouble : "";
  }
  const bool takes_vmc = HasPath(receiver, "/VMC");
  const bool takes_vrchat = HasPath(receiver, "/tracking") || HasPath(receiver, "/avatar");
  if (vrchat ? takes_vrchat : takes_vmc) return "";
  if (takes_vmc) return name + " takes VMC, not VRChat's trackers; leave --as vrchat out";
  if (takes_vrchat) return name + " takes VRChat's trackers, not VMC; add --as vrchat";
  return name + " takes neither VMC nor VRChat's trackers";
}

}  // namespace

Result<std::vector<TargetSpec>> FindTargets(const std::vector<std::string>& texts, bool vrchat) {
  std::vector<TargetSpec> targets;
  if (texts.empty()) return targets;
  const auto receivers = oscquery::FindReceivers(kSearch);
  if (!receivers.ok()) return Status::Error("--find: " + receivers.status().message());
  for (const std::string& text : texts) {
    const std::size_t sign = text.find('=');
    const bool named = sign != std::string::npos && client::IsPerformerId(text.substr(0, sign));
    const std::string name = named ? text.substr(sign + 1) : text;
    const auto chosen = oscquery::Choose(receivers.value(), name);
    const auto wrong = [&text](const std::string& why) {
      return Status::Error("--find '" + Printable(text, 80) + "': " + why);
    };
    if (!chosen.ok()) return wrong(chosen.status().message());
    const oscquery::Receiver& receiver = chosen.value();
    if (const std::string why = WhyNot(receiver, vrchat); !why.empty()) return wrong(why);
    TargetSpec target;
    if (named) target.performer = text.substr(0, sign);
    target.host = receiver.address;
    target.port = std::to_string(receiver.port);
    target.text = Printable(receiver.name, 63) + " (" + receiver.address + ":" + target.port + ")";
    targets.push_back(std::move(target));
  }
  return targets;
}

}  // namespace styled::stylevmc
