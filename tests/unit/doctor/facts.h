#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "clients/doctor/diagnose.h"

// Facts put together by hand, for tests of Diagnose().
namespace styled::doctor::testing {

inline Sniffed What(Format format, Verdict verdict, const std::string& kind) {
  return {format, verdict, kind};
}

// `count` datagrams a second for three seconds from 192.0.2.9.
inline Flow FlowTo(const std::string& to, const Sniffed& what, std::uint64_t count = 180,
                   const std::string& interface = "eth0", bool stream = false) {
  Flow flow;
  flow.stream = stream;
  flow.to = ParseEndpoint(to).value_or(Endpoint());
  flow.from = {"192.0.2.9", 50000};
  flow.interface = interface;
  flow.datagrams = count;
  flow.last_s = 3;
  flow.tally.Add(what, count);
  return flow;
}

inline Flow MvnTo(const std::string& to) {
  return FlowTo(to, What(Format::kMvn, Verdict::kPose, "quaternions (02)"));
}

// Why the lines of a finding's `change` that are to be copied cannot be; "": they can, or there are
// none.
std::string WhyNotCopied(const std::string& change);

// A machine with one network and a daemon that has the source "suit".
class Machine {
 public:
  Machine() {
    facts.seconds = 3;
    facts.capture = "not asked for";
    Interface lo{"lo", 1, true, true, false, true, {"127.0.0.1"}, {}};
    Interface eth0{"eth0", 2, true, true, true, false, {"192.0.2.1"}, {"192.0.2.255"}};
    facts.interfaces = {lo, eth0};
    facts.daemon.endpoint = "tcp://127.0.0.1:7002";
    facts.daemon.state = DaemonFacts::State::kAnswers;
  }

  // In the daemon, which receives this many datagrams.
  SourceFacts& InDaemon(const std::string& type, const std::string& listen, std::uint64_t received,
                        const std::string& name = "suit") {
    SourceFacts& source = facts.sources.emplace_back();
    source.expected = MakeExpected(ExpectedSource::Origin::kDaemon, name, type, listen);
    source.in_daemon = true;
    source.received = received;
    return source;
  }
  // In a file; we listen there.
  SourceFacts& Configured(const std::string& type, const std::string& listen,
                          const std::string& name = "suit") {
    facts.from_file = true;
    SourceFacts& source = facts.sources.emplace_back();
    source.expected = MakeExpected(ExpectedSource::Origin::kConfig, name, type, listen);
    source.port = PortState{
        source.expected.stream, source.expected.listen.port, PortState::Kind::kHeard, {}, ""};
    return source;
  }
  void NoDaemon() { facts.daemon.state = DaemonFacts::State::kSilent; }
  void Grow(const std::string& counter, std::uint64_t by) {
    for (auto* status : {&facts.daemon.before, &facts.daemon.after}) {
      auto& row = *status->mutable_stats()->add_counters();
      row.set_name(counter);
      row.set_value(status == &facts.daemon.before ? 100 : 100 + by);
    }
  }
  void LivePerformer(const std::string& id, const std::string& style = "old") {
    auto& performer = *facts.daemon.after.mutable_stats()->add_performers();
    performer.set_performer(id);
    performer.set_live(true);
    performer.mutable_look()->set_strength(1);
    if (!style.empty()) performer.mutable_look()->add_mix()->set_style(style);
  }

  // Of all findings of all tests: what is to be copied can be.
  std::vector<Finding> Findings() const {
    auto findings = Diagnose(facts);
    for (const Finding& finding : findings) {
      EXPECT_EQ(WhyNotCopied(finding.change), "") << finding.change;
    }
    return findings;
  }
  // "problem wrong_format suit", one after the other.
  std::string Codes() const {
    std::string out;
    for (const Finding& f : Findings()) {
      EXPECT_FALSE(f.what.empty()) << f.code;
      EXPECT_FALSE(f.change.empty()) << f.code;
      out += (out.empty() ? "" : "; ") + std::string(Name(f.severity)) + " " + f.code +
             (f.source.empty() ? "" : " " + f.source);
    }
    return out;
  }
  Finding First() const {
    const auto findings = Findings();
    return findings.empty() ? Finding() : findings.front();
  }

  Facts facts;
};

}  // namespace styled::doctor::testing
