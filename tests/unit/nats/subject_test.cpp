#include "clients/nats/subject.h"

#include <gtest/gtest.h>

#include <random>

namespace styled::stylenats {
namespace {

TEST(NatsSubject, RefusesWhatEscapeDoesNotWrite) {
  for (const std::string& hostile :
       {std::string(),           std::string("a.b"),      std::string("*"),
        std::string(">"),        std::string("a b"),      std::string("="),
        std::string("=2"),       std::string("a="),       std::string("a=2"),
        std::string("=2e"),      std::string("=2G"),      std::string("=G2"),
        std::string("=41"),      std::string("=2D"),      std::string("=5F"),
        std::string("a/b"),      std::string("\xC3\xA4"), std::string("a\0b", 3),
        std::string("=\0\0", 3), std::string("==3D"),     std::string("= 2E")}) {
    EXPECT_FALSE(Unescape(hostile)) << hostile;
  }
}

TEST(NatsSubject, EveryByteComesBack) {
  std::string all;
  for (int byte = 0; byte < 256; ++byte) {
    const std::string name(1, static_cast<char>(byte));
    EXPECT_EQ(Unescape(Escape(name)), name) << byte;
    all += name;
  }
  EXPECT_EQ(Unescape(Escape(all)), all);
}

TEST(NatsSubject, HasNoCharacterThatMeansSomethingToNats) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string name(1 + random() % 40, ' ');
    for (char& c : name) c = static_cast<char>(random());
    const std::string token = Escape(name);
    EXPECT_EQ(token.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                      "0123456789_-="),
              std::string::npos);
    EXPECT_EQ(Unescape(token), name);
  }
}

// Whatever is accepted is written back as it was: two tokens are never one name.
TEST(NatsSubject, UnescapesOneTokenForEachName) {
  std::mt19937 random(2);
  const std::string letters = "=0123456789ABCDEFaf.-_*> ";
  int accepted = 0;
  for (int i = 0; i < 200000; ++i) {
    std::string token(1 + random() % 6, ' ');
    for (char& c : token) c = letters[random() % letters.size()];
    const auto name = Unescape(token);
    if (!name) continue;
    ++accepted;
    ASSERT_EQ(Escape(*name), token);
  }
  EXPECT_GT(accepted, 1000);
}

TEST(NatsSubject, NamesAreTokensOfTheirOwn) {
  EXPECT_EQ(FrameSubject("hall 1", "rig.sim", "canonical"), "styled.hall=201.rig=2Esim.canonical");
  EXPECT_EQ(ControlSubject("hall.1"), "styledctl.hall=2E1");
  EXPECT_EQ(BodyKey("hall", "rig.sim", "hero"), "hall.body.rig=2Esim.hero");
  EXPECT_EQ(PerformerKey("hall", "rig.sim"), "hall.performer.rig=2Esim");
}

}  // namespace
}  // namespace styled::stylenats
