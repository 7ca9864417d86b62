#include "clients/web/mailbox.h"

#include <gtest/gtest.h>

namespace styled::web {
namespace {

MessagePtr Make(const std::string& key, const std::string& bytes) {
  return std::make_shared<Message>(Message{key, bytes, false});
}

TEST(MailboxTest, TheNewestOfAKeyWinsAndKeepsItsTurn) {
  Mailbox mailbox;
  EXPECT_EQ(mailbox.Pop(), nullptr);
  EXPECT_FALSE(mailbox.Put(Make("a", "a1")));
  EXPECT_FALSE(mailbox.Put(Make("b", "b1")));
  EXPECT_TRUE(mailbox.Put(Make("a", "a2")));
  EXPECT_TRUE(mailbox.Put(Make("a", "a3")));
  EXPECT_EQ(mailbox.size(), 2U);
  EXPECT_EQ(mailbox.Pop()->bytes, "a3");
  EXPECT_FALSE(mailbox.Put(Make("a", "a4"))) << "what was taken is superseded no more";
  EXPECT_EQ(mailbox.Pop()->bytes, "b1");
  EXPECT_EQ(mailbox.Pop()->bytes, "a4");
  EXPECT_EQ(mailbox.Pop(), nullptr);
}

TEST(MailboxTest, MessagesWithoutKeyAllStay) {
  Mailbox mailbox;
  mailbox.Put(Make("", "reply 1"));
  mailbox.Put(Make("a", "a1"));
  mailbox.Put(Make("", "reply 2"));
  mailbox.Put(Make("a", "a2"));
  EXPECT_EQ(mailbox.Pop()->bytes, "reply 1");
  EXPECT_EQ(mailbox.Pop()->bytes, "a2");
  EXPECT_EQ(mailbox.Pop()->bytes, "reply 2");
}

TEST(MailboxTest, AMillionMessagesToWhoDoesNotReadAreOnePerKey) {
  Mailbox mailbox;
  for (int i = 0; i < 1'000'000; ++i) {
    mailbox.Put(Make(std::to_string(i % 8), std::to_string(i)));
    if (i % 1000 == 0 && i < 500'000) mailbox.Pop();  // slow at first, then not at all
  }
  ASSERT_EQ(mailbox.size(), 8U);
  for (int i = 0; i < 8; ++i) EXPECT_GE(std::stoi(mailbox.Pop()->bytes), 999'992);
}

}  // namespace
}  // namespace styled::web
