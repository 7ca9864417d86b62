#include "clients/web/crowd.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace styled::web {
namespace {

using State = Crowd::State;

class CrowdTest : public testing::Test {
 protected:
  std::unique_ptr<Crowd::Member> Come(const std::string& name, State state = State::kReading) {
    auto member =
        std::make_unique<Crowd::Member>(crowd_, [this, name] { closed_.push_back(name); });
    member->Now(state);
    return member;
  }
  std::shared_ptr<Crowd> crowd_ = std::make_shared<Crowd>();
  std::vector<std::string> closed_;
};

TEST_F(CrowdTest, TheLongestUnfinishedRequestGivesWayFirst) {
  auto a = Come("a"), b = Come("b"), c = Come("c");
  a->Now(State::kReading);  // has asked once, and waits again
  EXPECT_TRUE(crowd_->MakeRoom());
  EXPECT_TRUE(crowd_->MakeRoom());
  EXPECT_EQ(closed_, (std::vector<std::string>{"b", "c"}));
  EXPECT_EQ(crowd_->size(), 1U) << "who gave way does not count, though still here";
  b->Now(State::kWriting);
  EXPECT_EQ(crowd_->size(), 1U);
  b.reset();
  EXPECT_EQ(crowd_->size(), 1U);
}

TEST_F(CrowdTest, RequestsGiveWayBeforeRepliesAndBrowsersNever) {
  auto browser = Come("browser", State::kBrowser), old = Come("old", State::kWriting),
       reply = Come("reply", State::kWriting), request = Come("request");
  EXPECT_TRUE(crowd_->MakeRoom());
  EXPECT_TRUE(crowd_->MakeRoom());
  EXPECT_TRUE(crowd_->MakeRoom());
  EXPECT_FALSE(crowd_->MakeRoom());
  EXPECT_EQ(closed_, (std::vector<std::string>{"request", "old", "reply"}));
  EXPECT_EQ(crowd_->size(), 1U);
}

TEST_F(CrowdTest, AMemberMayOutliveEverybodyElse) {
  const std::weak_ptr<Crowd> crowd = crowd_;
  auto last = Come("last");
  crowd_.reset();
  EXPECT_FALSE(crowd.expired()) << "the member still leaves it";
  last.reset();
  EXPECT_TRUE(crowd.expired());
  EXPECT_TRUE(closed_.empty());
}

}  // namespace
}  // namespace styled::web
