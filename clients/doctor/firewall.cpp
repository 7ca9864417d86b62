#include "clients/doctor/firewall.h"

#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "clients/doctor/address.h"

namespace styled::doctor {
namespace {

using nlohmann::json;

enum class Match { kNo, kYes, kUnknown };

Match And(Match a, Match b) {
  if (a == Match::kNo || b == Match::kNo) return Match::kNo;
  return a == Match::kYes && b == Match::kYes ? Match::kYes : Match::kUnknown;
}
Match Not(Match a) {
  if (a == Match::kUnknown) return a;
  return a == Match::kYes ? Match::kNo : Match::kYes;
}

std::string Text(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

// On systems without protocol names, nft prints numbers.
std::string Protocol(const json& value) {
  const std::string text = Text(value);
  if (text == "17") return "udp";
  return text == "6" ? "tcp" : text;
}

std::string Field(const json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? Text(*found) : "";
}

// Follows one packet through the chains of one hook.
class Walk {
 public:
  Walk(const json& rules, const Firewall::Packet& packet) : rules_(rules), packet_(packet) {}

  // Enters a base chain of the hook. The packet passes only if all base chains accept it.
  void Enter(const json& chain) {
    family_ = Field(chain, "family");
    table_ = Field(chain, "table");
    doubts_ = 0;
    const std::string name = Field(chain, "name");
    const End end = Run(name, Match::kYes, 0);
    const bool through = end == End::kFallsThrough || end == End::kReturn;
    if (through && Field(chain, "policy") == "drop") Drop(Match::kYes, name, "policy drop");
  }

  Firewall::Judgement judgement;

 private:
  enum class End { kFallsThrough, kReturn, kAccepted, kDropped };
  static constexpr int kMaxDepth = 16;
  // Limit over all chains, since jumps can multiply the work.
  static constexpr int kMaxRules = 100000;

  void Drop(Match matches, const std::string& chain, const std::string& what) {
    // If an earlier rule may have accepted the packet, a later drop is not certain.
    const bool certain = matches == Match::kYes && doubts_ == 0;
    if (judgement.verdict == Firewall::Verdict::kDropped) return;
    if (!certain && judgement.verdict == Firewall::Verdict::kDepends) return;
    judgement.verdict = certain ? Firewall::Verdict::kDropped : Firewall::Verdict::kDepends;
    judgement.rule = family_ + " " + table_ + " " + chain + ": " + what;
  }

  // `path`: whether the packet reaches this chain.
  End Run(const std::string& chain, Match path, int depth) {
    if (depth > kMaxDepth) return End::kFallsThrough;
    for (const auto& entry : rules_) {
      const auto rule = entry.find("rule");
      if (rule == entry.end() || Field(*rule, "family") != family_ ||
          Field(*rule, "table") != table_ || Field(*rule, "chain") != chain) {
        continue;
      }
      const auto expressions = rule->find("expr");
      if (expressions == rule->end()) continue;
      if (++looked_at_ > kMaxRules) return End::kFallsThrough;
      const End end = RunRule(*expressions, chain, path, depth);
      if (end != End::kFallsThrough) return end;
    }
    return End::kFallsThrough;
  }

  End RunRule(const json& expressions, const std::string& chain, Match path, int depth) {
    // nft evaluates expressions from left to right: a verdict applies if all matches before it
    // hold.
    Match matches = Match::kYes;
    for (const auto& expression : expressions) {
      if (!expression.is_object() || expression.empty()) continue;
      const std::string what = expression.begin().key();
      const json& body = expression.begin().value();
      if (what == "match") {
        matches = And(matches, MatchOf(body));
      } else if (what == "limit") {
        matches = And(matches, Match::kUnknown);
      } else if (what == "vmap" && matches != Match::kNo) {
        const End end = RunMap(body, matches, chain, path, depth);
        if (end != End::kFallsThrough) return end;
      } else if (what == "xt" && Field(body, "type") != "target") {
        matches = And(matches, MatchOfIptables(Field(body, "name"), expressions));
      } else if (matches != Match::kNo) {
        const End end = RunVerdict(what, body, matches, chain, path, depth);
        if (end != End::kFallsThrough) return end;
      }
    }
    return End::kFallsThrough;
  }

  // "udp dport vmap { 7000 : accept, 7001 : drop }".
  End RunMap(const json& body, Match matches, const std::string& chain, Match path, int depth) {
    const auto key = body.find("key");
    const auto data = body.find("data");
    const bool readable = key != body.end() && data != body.end() && data->is_object() &&
                          data->contains("set") && (*data)["set"].is_array();
    if (!readable) {
      ++doubts_;
      return End::kFallsThrough;
    }
    if (OfAnotherProtocol(*key)) return End::kFallsThrough;
    for (const auto& entry : (*data)["set"]) {
      if (!entry.is_array() || entry.size() != 2 || !entry[1].is_object() || entry[1].empty()) {
        continue;
      }
      const Match here = And(matches, Compare(*key, entry[0]));
      if (here == Match::kNo) continue;
      const auto verdict = entry[1].begin();
      const End end = RunVerdict(verdict.key(), verdict.value(), here, chain, path, depth);
      if (end != End::kFallsThrough) return end;
    }
    return End::kFallsThrough;
  }

  // The JSON contains only the names of iptables' own matches, not their parameters.
  static Match MatchOfIptables(const std::string& name, const json& expressions) {
    if (name == "comment") return Match::kYes;
    const bool state = name == "conntrack" || name == "state";
    const bool port = std::ranges::any_of(expressions, [](const json& e) {
      return e.is_object() && e.contains("match") && e["match"].contains("left") &&
             e["match"]["left"].contains("payload");
    });
    // Without a port condition this is the rule for ESTABLISHED (or INVALID), not for a new packet.
    return state && !port ? Match::kNo : Match::kUnknown;
  }

  End RunVerdict(const std::string& what, const json& body, Match matches, const std::string& chain,
                 Match path, int depth) {
    const bool sure = matches == Match::kYes;
    const std::string target = what == "xt" ? Field(body, "name") : "";
    if (what == "accept" || what == "queue") {
      if (And(path, matches) != Match::kYes) ++doubts_;
      return sure ? End::kAccepted : End::kFallsThrough;
    }
    if (what == "drop" || what == "reject" || target == "REJECT") {
      Drop(And(path, matches), chain, what == "drop" ? "drop" : "reject");
      return sure ? End::kDropped : End::kFallsThrough;
    }
    if (what == "return") {
      if (!sure) ++doubts_;
      return sure ? End::kReturn : End::kFallsThrough;
    }
    if (what != "jump" && what != "goto") return End::kFallsThrough;
    const End end = Run(Field(body, "target"), And(path, matches), depth + 1);
    if (!sure) return End::kFallsThrough;
    if (end == End::kAccepted || end == End::kDropped) return end;
    return what == "goto" ? End::kReturn : End::kFallsThrough;
  }

  Match MatchOf(const json& body) const {
    const auto left = body.find("left");
    const auto right = body.find("right");
    if (left == body.end() || right == body.end()) return Match::kUnknown;
    // Even "port is not 80" applies only to packets of the same protocol.
    if (OfAnotherProtocol(*left)) return Match::kNo;
    const std::string op = Field(body, "op");
    const Match equal = Compare(*left, *right);
    if (op == "==" || op == "in") return equal;
    return op == "!=" ? Not(equal) : Match::kUnknown;
  }

  bool OfAnotherProtocol(const json& left) const {
    if (!left.is_object() || !left.contains("payload")) return false;
    const std::string protocol = Field(left["payload"], "protocol");
    const bool ours = protocol == "th" || protocol == "ip" || protocol == "ether" ||
                      protocol == (packet_.stream ? "tcp" : "udp");
    return !ours && !protocol.empty();
  }

  Match Compare(const json& left, const json& right) const {
    if (!left.is_object() || left.empty()) return Match::kUnknown;
    const std::string what = left.begin().key();
    const json& body = left.begin().value();
    const std::string key = Field(body, "key"), field = Field(body, "field");
    if (what == "payload") return ComparePayload(Field(body, "protocol"), field, right);
    if (what == "meta" && key == "l4proto") return Contains(right, packet_.stream ? "tcp" : "udp");
    if (what == "meta" && (key == "iif" || key == "iifname")) {
      if (!packet_.interface.empty()) return Contains(right, packet_.interface);
      // Matches some interface, but not loopback.
      return Contains(right, "lo") == Match::kYes && !right.is_object() ? Match::kNo
                                                                        : Match::kUnknown;
    }
    if (what == "meta" && key == "pkttype")
      return Contains(right, Multicast() ? "multicast" : "host");
    if (what == "meta" && key == "nfproto") return Contains(right, "ipv4");
    if (what == "ct" && key == "state") return Contains(right, "new");
    return Match::kUnknown;
  }

  Match ComparePayload(const std::string& protocol, const std::string& field,
                       const json& right) const {
    if (field == "dport") return ContainsPort(right);
    if (protocol != "ip") return Match::kUnknown;
    if (field == "protocol") return Contains(right, packet_.stream ? "tcp" : "udp");
    if (field != "daddr") return Match::kUnknown;
    if (!packet_.destination.empty()) return Contains(right, packet_.destination);
    // An address of this machine is not a multicast group.
    return right.is_string() && IsMulticast(right.get<std::string>()) ? Match::kNo
                                                                      : Match::kUnknown;
  }

  bool Multicast() const { return IsMulticast(packet_.destination); }

  // The elements of a value, a list, { a, b } or @name; empty if they are unknown.
  std::optional<std::vector<json>> Elements(const json& value) const {
    if (value.is_array()) return std::vector<json>(value.begin(), value.end());
    if (value.is_object() && value.contains("set")) return Elements(value["set"]);
    const std::string name = value.is_string() ? value.get<std::string>() : "";
    if (!name.starts_with('@')) return std::vector<json>{value};
    for (const auto& entry : rules_) {
      const auto set = entry.find("set");
      if (set == entry.end() || Field(*set, "name") != name.substr(1) ||
          Field(*set, "table") != table_ || Field(*set, "family") != family_) {
        continue;
      }
      return set->contains("elem") ? Elements((*set)["elem"]) : std::vector<json>();
    }
    return std::nullopt;
  }

  Match Contains(const json& value, const std::string& expected) const {
    const auto elements = Elements(value);
    if (!elements) return Match::kUnknown;
    Match found = Match::kNo;
    for (const auto& element : *elements) {
      if (element.is_object()) {
        found = Match::kUnknown;  // a range, a prefix
      } else if (Text(element) == expected || Protocol(element) == expected) {
        return Match::kYes;
      }
    }
    return found;
  }

  Match ContainsPort(const json& value) const {
    const auto elements = Elements(value);
    if (!elements) return Match::kUnknown;
    Match found = Match::kNo;
    for (const auto& element : *elements) {
      const auto range = element.is_object() ? element.find("range") : element.end();
      const bool is_range = element.is_object() && range != element.end() && range->size() == 2 &&
                            (*range)[0].is_number() && (*range)[1].is_number();
      if (is_range) {
        const int low = (*range)[0].get<int>(), high = (*range)[1].get<int>();
        if (packet_.port >= low && packet_.port <= high) return Match::kYes;
      } else if (element.is_number()) {
        if (element.get<int>() == packet_.port) return Match::kYes;
      } else {
        found = Match::kUnknown;
      }
    }
    return found;
  }

  const json& rules_;
  const Firewall::Packet& packet_;
  std::string family_, table_;
  int looked_at_ = 0;
  int doubts_ = 0;  // number of earlier rules that may have accepted the packet
};

}  // namespace

Firewall Firewall::Read() {
  // The command is constant: no user input reaches the shell.
  FILE* pipe = popen("PATH=$PATH:/usr/sbin:/sbin nft --json list ruleset 2>/dev/null", "re");
  Firewall out;
  out.why_ = "nft cannot be run";
  if (pipe == nullptr) return out;
  std::string text;
  std::array<char, 4096> buffer{};
  constexpr std::size_t kMaxText = 16 << 20;
  for (std::size_t n = 1; n > 0 && text.size() < kMaxText;) {
    n = fread(buffer.data(), 1, buffer.size(), pipe);
    text.append(buffer.data(), n);
  }
  const int status = pclose(pipe);
  if (status == 0) return FromJson(text);
  constexpr int kNotFound = 127;
  const bool missing = WIFEXITED(status) && WEXITSTATUS(status) == kNotFound;
  out.why_ = missing ? "nft is not installed" : "nft needs root's rights";
  return out;
}

Firewall Firewall::FromJson(const std::string& text) {
  Firewall out;
  const json parsed = json::parse(text, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("nftables") || !parsed["nftables"].is_array()) {
    out.why_ = "nft's output cannot be parsed";
    return out;
  }
  json rules = json::array();
  for (const auto& entry : parsed["nftables"]) {
    if (entry.is_object()) rules.push_back(entry);
  }
  out.rules_ = std::make_shared<const json>(std::move(rules));
  return out;
}

Firewall::Judgement Firewall::Judge(const Packet& packet) const {
  if (rules_ == nullptr) return {};
  Walk walk(*rules_, packet);
  for (const auto& entry : *rules_) {
    const auto chain = entry.find("chain");
    if (chain == entry.end()) continue;
    const std::string hook = Field(*chain, "hook"), family = Field(*chain, "family");
    const bool filters = hook == "input" || hook == "prerouting";
    const bool mine = family == "inet" || family == "ip";
    if (filters && mine && Field(*chain, "type") == "filter") walk.Enter(*chain);
  }
  return walk.judgement;
}

}  // namespace styled::doctor
