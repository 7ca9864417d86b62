#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <sstream>

#include "tests/unit/doctor/facts.h"

namespace styled::doctor::testing {

std::string WhyNotCopied(const std::string& change) {
  const std::size_t first = change.find('\n');
  if (first == std::string::npos) {
    const bool table = change.find("]] ") != std::string::npos;  // that is only named, has no keys
    return table && change.find(" = ") != std::string::npos ? "a table within a sentence" : "";
  }
  const std::string copied = change.substr(first + 1);
  if (copied.starts_with("[")) {
    try {
      (void)toml::parse(copied);
      return "";
    } catch (const toml::parse_error& error) {
      return std::string(error.description());
    }
  }
  std::istringstream lines(copied);
  for (std::string line; std::getline(lines, line);) {
    const std::string program = line.substr(0, line.find(' '));
    const auto known = {"stylectl", "systemctl", "sysctl", "ufw", "firewall-cmd", "nft"};
    if (std::ranges::find(known, program) == known.end()) return "no command: " + line;
    if (line.find_first_of("\"'();,") != std::string::npos || line.ends_with('.')) {
      return "more than a command: " + line;
    }
  }
  return "";
}

namespace {

TEST(WhyNotCopied, FindsWhatDoesNotParse) {
  EXPECT_EQ(WhyNotCopied("Stop it."), "");
  EXPECT_EQ(WhyNotCopied("Make another [[source]] for it."), "");
  EXPECT_EQ(WhyNotCopied("Add:\n[[source]]\nname = \"rig\""), "");
  EXPECT_NE(WhyNotCopied("Add:  [[source]] name = \"rig\""), "");
  EXPECT_NE(WhyNotCopied("Add:\n[[source]] name = \"rig\""), "");
  EXPECT_NE(WhyNotCopied("Add:\n[[source]]\nmerge_into = \"a\" (the performer)"), "");
  EXPECT_EQ(WhyNotCopied("Open:\nufw allow 1/udp\nnft insert rule inet filter input accept"), "");
  EXPECT_NE(WhyNotCopied("Open:\nnft insert rule inet filter input accept."), "");
  EXPECT_NE(WhyNotCopied("Open:\nthe port"), "");
}

// Findings() checks that it can be copied.
TEST(WhyNotCopied, ASourceForTheFaceOfOneOfTwoPerformersCanBeCopied) {
  Machine machine;
  machine.LivePerformer("stage.anna");
  machine.LivePerformer("stage.ben");
  machine.InDaemon("udp", "127.0.0.1:7010", 0, "other");
  machine.facts.seen = {
      FlowTo("192.0.2.1:11111", What(Format::kLiveLinkFace, Verdict::kPose, "facial expressions"))};
  const auto findings = machine.Findings();
  const auto found = std::ranges::find(findings, "no_source", &Finding::code);
  ASSERT_NE(found, findings.end());
  EXPECT_NE(found->change.find("\nmerge_into = \"stage.anna\""), std::string::npos)
      << found->change;
}

}  // namespace
}  // namespace styled::doctor::testing
