// Rulesets as nft 1.0.6 printed them (nft --json list ruleset): one written for nft by hand, one
// that iptables-nft made.
#include "clients/doctor/firewall.h"

#include <gtest/gtest.h>

namespace styled::doctor {
namespace {

constexpr const char* kNft = R"json(
{"nftables": [
{"metainfo": {"version": "1.0.6", "release_name": "Lester Gooch #5", "json_schema_version":
  1}},
{"table": {"family": "inet", "name": "filter", "handle": 1}},
{"set": {"family": "inet", "name": "allowed", "table": "filter", "type": "inet_service",
  "handle": 4, "flags": ["interval"], "elem": [22, {"range": [7000, 7010]}, 39539]}},
{"chain": {"family": "inet", "table": "filter", "name": "services", "handle": 1}},
{"chain": {"family": "inet", "table": "filter", "name": "input", "handle": 2, "type":
  "filter", "hook": "input", "prio": 0, "policy": "drop"}},
{"chain": {"family": "inet", "table": "filter", "name": "rest", "handle": 3}},
{"rule": {"family": "inet", "table": "filter", "chain": "services", "handle": 5, "expr":
  [{"match": {"op": "==", "left": {"payload": {"protocol": "udp", "field": "dport"}}, "right":
  "@allowed"}}, {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "services", "handle": 7, "expr":
  [{"match": {"op": "==", "left": {"payload": {"protocol": "udp", "field": "dport"}}, "right":
  {"set": [12351, {"range": [14043, 14050]}]}}}, {"counter": {"packets": 0, "bytes": 0}},
  {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "services", "handle": 8, "expr":
  [{"match": {"op": "==", "left": {"payload": {"protocol": "ip", "field": "saddr"}}, "right":
  {"prefix": {"addr": "10.0.0.0", "len": 8}}}}, {"match": {"op": "==", "left": {"payload":
  {"protocol": "udp", "field": "dport"}}, "right": 6969}}, {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "services", "handle": 9, "expr":
  [{"match": {"op": "==", "left": {"payload": {"protocol": "udp", "field": "dport"}}, "right":
  6969}}, {"reject": {"type": "icmp", "expr": "port-unreachable"}}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 10, "expr":
  [{"match": {"op": "in", "left": {"ct": {"key": "state"}}, "right": ["established",
  "related"]}}, {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 11, "expr":
  [{"match": {"op": "in", "left": {"ct": {"key": "state"}}, "right": "invalid"}}, {"drop":
  null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 12, "expr":
  [{"match": {"op": "==", "left": {"meta": {"key": "iifname"}}, "right": "lo"}}, {"accept":
  null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 13, "expr":
  [{"match": {"op": "==", "left": {"meta": {"key": "iif"}}, "right": "lo"}}, {"accept":
  null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 14, "expr":
  [{"match": {"op": "!=", "left": {"payload": {"protocol": "tcp", "field": "dport"}}, "right":
  {"range": [1, 1024]}}}, {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 15, "expr":
  [{"match": {"op": "==", "left": {"payload": {"protocol": "ip", "field": "daddr"}}, "right":
  "239.255.42.99"}}, {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 17, "expr":
  [{"vmap": {"key": {"payload": {"protocol": "udp", "field": "dport"}}, "data": {"set":
  [[5000, {"accept": null}], [5001, {"drop": null}]]}}}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 19, "expr":
  [{"match": {"op": "==", "left": {"meta": {"key": "l4proto"}}, "right": {"set": ["icmp",
  "ipv6-icmp"]}}}, {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 20, "expr":
  [{"match": {"op": "==", "left": {"meta": {"key": "pkttype"}}, "right": "multicast"}},
  {"accept": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 21, "expr":
  [{"jump": {"target": "services"}}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 22, "expr":
  [{"limit": {"rate": 5, "burst": 5, "per": "minute"}}, {"log": {"prefix": "x"}}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "input", "handle": 23, "expr":
  [{"goto": {"target": "rest"}}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "rest", "handle": 24, "expr":
  [{"match": {"op": "==", "left": {"payload": {"protocol": "udp", "field": "dport"}}, "right":
  1511}}, {"return": null}]}},
{"rule": {"family": "inet", "table": "filter", "chain": "rest", "handle": 25, "expr":
  [{"match": {"op": "==", "left": {"payload": {"protocol": "udp", "field": "dport"}}, "right":
  9763}}, {"drop": null}]}}
]}
)json";

constexpr const char* kIptables = R"json(
{"nftables": [
{"metainfo": {"version": "1.0.6", "release_name": "Lester Gooch #5", "json_schema_version":
  1}},
{"table": {"family": "ip", "name": "filter", "handle": 1}},
{"chain": {"family": "ip", "table": "filter", "name": "INPUT", "handle": 1, "type": "filter",
  "hook": "input", "prio": 0, "policy": "drop"}},
{"chain": {"family": "ip", "table": "filter", "name": "ufw", "handle": 7}},
{"rule": {"family": "ip", "table": "filter", "chain": "INPUT", "handle": 2, "expr": [{"match":
  {"op": "==", "left": {"meta": {"key": "iifname"}}, "right": "lo"}}, {"counter": {"packets":
  0, "bytes": 0}}, {"accept": null}]}},
{"rule": {"family": "ip", "table": "filter", "chain": "INPUT", "handle": 3, "expr": [{"xt":
  {"type": "match", "name": "conntrack"}}, {"counter": {"packets": 0, "bytes": 0}}, {"accept":
  null}]}},
{"rule": {"family": "ip", "table": "filter", "chain": "INPUT", "handle": 4, "expr": [{"match":
  {"op": "==", "left": {"payload": {"protocol": "udp", "field": "dport"}}, "right": 9763}},
  {"counter": {"packets": 0, "bytes": 0}}, {"accept": null}]}},
{"rule": {"family": "ip", "table": "filter", "chain": "INPUT", "handle": 5, "expr": [{"match":
  {"op": "==", "left": {"meta": {"key": "l4proto"}}, "right": "udp"}}, {"xt": {"type":
  "match", "name": "multiport"}}, {"counter": {"packets": 0, "bytes": 0}}, {"accept": null}]}},
{"rule": {"family": "ip", "table": "filter", "chain": "INPUT", "handle": 6, "expr": [{"match":
  {"op": "==", "left": {"payload": {"protocol": "ip", "field": "saddr"}}, "right": {"prefix":
  {"addr": "10.0.0.0", "len": 8}}}}, {"match": {"op": "==", "left": {"payload": {"protocol":
  "udp", "field": "dport"}}, "right": 7000}}, {"xt": {"type": "match", "name": "comment"}},
  {"counter": {"packets": 0, "bytes": 0}}, {"accept": null}]}},
{"rule": {"family": "ip", "table": "filter", "chain": "INPUT", "handle": 8, "expr":
  [{"counter": {"packets": 0, "bytes": 0}}, {"jump": {"target": "ufw"}}]}},
{"rule": {"family": "ip", "table": "filter", "chain": "ufw", "handle": 9, "expr": [{"match":
  {"op": "==", "left": {"payload": {"protocol": "udp", "field": "dport"}}, "right": {"range":
  [7001, 7009]}}}, {"counter": {"packets": 0, "bytes": 0}}, {"xt": {"type": "target", "name":
  "REJECT"}}]}}
]}
)json";

class FirewallTest : public testing::Test {
 protected:
  std::string Judge(const char* rules, const Firewall::Packet& packet) {
    const Firewall firewall = Firewall::FromJson(rules);
    EXPECT_TRUE(firewall.readable()) << firewall.why();
    const auto judgement = firewall.Judge(packet);
    const char* const words[] = {"passes", "dropped", "depends"};
    const std::string rule = judgement.rule.empty() ? "" : " (" + judgement.rule + ")";
    return words[static_cast<int>(judgement.verdict)] + rule;
  }
  static Firewall::Packet Udp(std::uint16_t port) { return {false, port, "", ""}; }
};

TEST_F(FirewallTest, WhatIsNotUnderstoodIsNotReadable) {
  for (const char* text : {"", "nft: permission denied", "[]", "{}", R"({"nftables":3})"}) {
    EXPECT_FALSE(Firewall::FromJson(text).readable()) << text;
  }
}

TEST_F(FirewallTest, RulesOfTheWrongShapeDropNothing) {
  for (const char* text :
       {R"({"nftables":[]})", R"({"nftables":[1,{"rule":3},{"chain":null}]})",
        R"({"nftables":[{"chain":{"family":"inet","table":"t","name":"c","hook":"input",
            "type":"filter","policy":"accept"}},
            {"rule":{"family":"inet","table":"t","chain":"c","expr":[{"match":{}},{"vmap":7},3,{}]}},
            {"rule":{"family":"inet","table":"t","chain":"c","expr":[{"jump":{"target":"c"}}]}}]})"}) {
    EXPECT_EQ(Judge(text, Udp(9763)), "passes") << text;
  }
}

// The kernel refuses loops; what cannot be is not walked for ever.
TEST_F(FirewallTest, ChainsThatCallOneAnotherWithoutEndAreLeft) {
  std::string rules = R"({"nftables":[{"chain":{"family":"ip","table":"t","name":"c","hook":"input",
      "type":"filter","policy":"accept"}})";
  for (int i = 0; i < 20; ++i) {
    rules +=
        R"(,{"rule":{"family":"ip","table":"t","chain":"c","expr":[{"jump":{"target":"c"}}]}})";
  }
  EXPECT_EQ(Judge((rules + "]}").c_str(), Udp(9763)), "passes");
}

TEST_F(FirewallTest, PortsAreFoundInSetsRangesAndMaps) {
  EXPECT_EQ(Judge(kNft, Udp(7005)), "passes") << "in a named set's interval";
  EXPECT_EQ(Judge(kNft, Udp(39539)), "passes");
  EXPECT_EQ(Judge(kNft, Udp(12351)), "passes") << "in a set of the rule";
  EXPECT_EQ(Judge(kNft, Udp(14050)), "passes") << "in its range";
  EXPECT_EQ(Judge(kNft, Udp(5000)), "passes") << "in a map";
  EXPECT_EQ(Judge(kNft, Udp(5001)), "dropped (inet filter input: drop)");
}

TEST_F(FirewallTest, ADropIsNamedByItsChain) {
  EXPECT_EQ(Judge(kNft, Udp(9763)), "dropped (inet filter rest: drop)") << "past jump and goto";
  EXPECT_EQ(Judge(kNft, Udp(39540)), "dropped (inet filter input: policy drop)");
  EXPECT_EQ(Judge(kNft, Udp(1511)), "dropped (inet filter input: policy drop)") << "return";
}

TEST_F(FirewallTest, LoopbackGroupsAndTcpAreJudgedByThemselves) {
  EXPECT_EQ(Judge(kNft, {false, 9763, "lo", ""}), "passes");
  EXPECT_EQ(Judge(kNft, {false, 1511, "", "239.255.42.99"}), "passes");
  EXPECT_EQ(Judge(kNft, {true, 9763, "", ""}), "passes") << "tcp dport != 1-1024 accept";
  EXPECT_EQ(Judge(kNft, {true, 80, "", ""}), "dropped (inet filter input: policy drop)");
}

TEST_F(FirewallTest, WhatHangsOnTheSenderDepends) {
  EXPECT_EQ(Judge(kNft, Udp(6969)), "depends (inet filter services: reject)");
}

TEST_F(FirewallTest, RulesOfIptablesAreReadAsFarAsNftTellsThem) {
  EXPECT_EQ(Judge(kIptables, Udp(9763)), "passes");
  EXPECT_EQ(Judge(kIptables, {false, 8000, "lo", ""}), "passes");
  // After "multiport", of which nft does not tell the ports.
  EXPECT_EQ(Judge(kIptables, Udp(7005)), "depends (ip filter ufw: reject)");
  EXPECT_EQ(Judge(kIptables, {true, 8000, "", ""}), "dropped (ip filter INPUT: policy drop)");
}

}  // namespace
}  // namespace styled::doctor
