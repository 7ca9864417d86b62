// Every command has a row among the attacks: a new one is attacked from its first day.
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "tests/hostile/attacks.h"
#include "tests/support/child.h"

namespace styled::hostile {
namespace {

// The names of the fields of `oneof command` in a text of control.proto.
std::set<std::string> CommandsOf(const std::string& proto) {
  std::set<std::string> commands;
  const std::size_t begin = proto.find("oneof command {");
  const std::string fields = proto.substr(begin, proto.find("\n  }", begin) - begin);
  const std::regex field(R"((\w+) = \d+;)");
  for (std::sregex_iterator it(fields.begin(), fields.end(), field), end; it != end; ++it) {
    commands.insert((*it)[1]);
  }
  return commands;
}

TEST(TablesTest, EveryCommandIsAttacked) {
  const auto commands =
      CommandsOf(support::ReadText(STYLED_SOURCE_DIR "/proto/styled/v1/control.proto"));
  EXPECT_GE(commands.size(), 18U);
  std::set<std::string> attacked, names;
  for (const RequestAttack& attack : RequestAttacks()) {
    attacked.insert(attack.command);
    EXPECT_TRUE(names.insert(attack.command + "_" + attack.name).second) << attack.name << " twice";
  }
  EXPECT_EQ(attacked, commands);
}

TEST(TablesTest, ACommandWithoutARowIsSeen) {
  const auto commands =
      CommandsOf("oneof command {\n    List list = 3;\n    New new_one = 99;\n  }");
  EXPECT_EQ(commands, (std::set<std::string>{"list", "new_one"}));
}

}  // namespace
}  // namespace styled::hostile
