#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace styled::doctor {

// This machine's packet filter, as `nft --json list ruleset` tells it (rules made with
// iptables-nft, ufw and firewalld are in there, too). Pure but for Read(); pinned by
// tests/unit/doctor/firewall_test.cpp on rulesets that nft printed.
class Firewall {
 public:
  // Runs nft. Not readable without root's rights: then readable() is false and why() says so.
  static Firewall Read();
  static Firewall FromJson(const std::string& text);

  bool readable() const { return why_.empty(); }
  const std::string& why() const { return why_; }

  enum class Verdict {
    kPasses,
    kDropped,
    kDepends  // on who sends, or on a rule that is not understood here
  };
  struct Judgement {
    Verdict verdict = Verdict::kPasses;
    std::string
        rule;  // the one that drops, or on which it depends: "inet filter input: policy drop"
  };
  struct Packet {
    bool stream = false;
    std::uint16_t port = 0;
    std::string interface;    // that it comes in by; "": some, not loopback
    std::string destination;  // its address; "": this machine's
  };
  // What happens to a packet from a sender that we know nothing of, the first of its kind.
  Judgement Judge(const Packet& packet) const;

 private:
  std::string why_;
  std::shared_ptr<const nlohmann::json> rules_;  // null: none
};

}  // namespace styled::doctor
