#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace styled::doctor {

// This machine's packet filter, from the output of `nft --json list ruleset`. That includes rules
// made with iptables-nft, ufw and firewalld. Pure, except for Read(). Pinned by
// tests/unit/doctor/firewall_test.cpp with rulesets printed by nft.
class Firewall {
 public:
  // Runs nft, which needs root's rights. Without them readable() is false and why() returns the
  // reason.
  static Firewall Read();
  static Firewall FromJson(const std::string& text);

  bool readable() const { return why_.empty(); }
  const std::string& why() const { return why_; }

  enum class Verdict {
    kPasses,
    kDropped,
    kDepends  // on the sender, or on a rule that this class does not understand
  };
  struct Judgement {
    Verdict verdict = Verdict::kPasses;
    std::string rule;  // the deciding rule: "inet filter input: policy drop"
  };
  struct Packet {
    bool stream = false;
    std::uint16_t port = 0;
    std::string interface;    // by which it arrives; "": any except loopback
    std::string destination;  // its address; "": an address of this machine
  };
  // The verdict on the first packet of its kind, from an unknown sender.
  Judgement Judge(const Packet& packet) const;

 private:
  std::string why_;
  std::shared_ptr<const nlohmann::json> rules_;  // null: none
};

}  // namespace styled::doctor
