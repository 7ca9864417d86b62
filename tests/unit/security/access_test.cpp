#include "daemon/security/access.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>

#include "model/base/descriptor.h"

namespace styled::security {
namespace {

using keys::Client;
using keys::Role;

// A connection: ours, and the client's end of it.
struct Wire {
  Wire() {
    std::array<int, 2> fds{};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, fds.data()), 0);
    ours = Descriptor(fds[0]);
    theirs = Descriptor(fds[1]);
  }
  bool Ended() const {
    pollfd end{theirs.get(), POLLIN, 0};
    char byte = 0;
    return poll(&end, 1, 0) == 1 && read(theirs.get(), &byte, 1) == 0;
  }
  Descriptor ours, theirs;
};

const Client kAnna{"anna", "key of anna", Role::kOperator};
const Client kBob{"bob", "key of bob", Role::kSubscriber};

TEST(AccessTest, ARoleOpensItsDoorsAndAnUnknownKeyNone) {
  Access access;
  EXPECT_EQ(access.Judge(kAnna.key, Door::kPublish), Access::Verdict::kUnknownKey);
  (void)access.Replace({kAnna, kBob});
  EXPECT_EQ(access.Judge(kAnna.key, Door::kPublish), Access::Verdict::kAllowed);
  EXPECT_EQ(access.Judge(kAnna.key, Door::kControl), Access::Verdict::kAllowed);
  EXPECT_EQ(access.Judge(kBob.key, Door::kPublish), Access::Verdict::kAllowed);
  Client who;
  EXPECT_EQ(access.Judge(kBob.key, Door::kControl, &who), Access::Verdict::kRole);
  EXPECT_EQ(who, kBob);
  EXPECT_EQ(access.Judge("", Door::kPublish), Access::Verdict::kUnknownKey);
}

TEST(AccessTest, ARevokedClientIsCutAndNoOther) {
  Access access;
  (void)access.Replace({kAnna, kBob});
  const Wire anna, bob, bob_too;
  access.NoteSubscriber(kAnna.key, anna.ours.get());
  for (int i = 0; i < 3; ++i) access.NoteSubscriber(kBob.key, bob.ours.get());
  access.NoteSubscriber(kBob.key, bob_too.ours.get());
  const auto change = access.Replace({kAnna});
  EXPECT_EQ(change.cut, 2);
  EXPECT_EQ(change.revoked, std::vector<Client>{kBob});
  EXPECT_TRUE(change.allowed.empty());
  EXPECT_TRUE(bob.Ended() && bob_too.Ended());
  EXPECT_FALSE(anna.Ended());
  EXPECT_EQ(access.Sweep(), 0);
}

TEST(AccessTest, ANewKeyUnderTheSameNameCutsTheOldOne) {
  Access access;
  (void)access.Replace({kBob});
  const Wire wire;
  access.NoteSubscriber(kBob.key, wire.ours.get());
  EXPECT_EQ(access.Replace({Client{"bob", "another key", Role::kSubscriber}}).cut, 1);
  EXPECT_TRUE(wire.Ended());
}

TEST(AccessTest, AnotherRoleCutsNoFrames) {
  Access access;
  (void)access.Replace({kAnna});
  const Wire wire;
  access.NoteSubscriber(kAnna.key, wire.ours.get());
  const auto change = access.Replace({Client{"anna", kAnna.key, Role::kSubscriber}});
  EXPECT_EQ(change.cut, 0);
  EXPECT_FALSE(wire.Ended());
  EXPECT_EQ(access.Judge(kAnna.key, Door::kControl), Access::Verdict::kRole);
}

TEST(AccessTest, ARevokedClientThatSubscribesIsCutAtOnce) {
  Access access;
  const Wire wire;
  access.NoteSubscriber(kBob.key, wire.ours.get());
  EXPECT_TRUE(wire.Ended());
}

// The number of a connection that ended is the next one's.
TEST(AccessTest, AnotherConnectionOfTheSameNumberIsNotCut) {
  Access access;
  (void)access.Replace({kAnna, kBob});
  auto bob = std::make_unique<Wire>();
  const int number = bob->ours.get();
  access.NoteSubscriber(kBob.key, number);
  bob.reset();
  const Wire anna;
  const Descriptor same(dup2(anna.ours.get(), number));
  ASSERT_EQ(same.get(), number);
  EXPECT_EQ(access.Replace({kAnna}).cut, 0);
  EXPECT_FALSE(anna.Ended());
}

TEST(AccessTest, OtherFilesThanSocketsAreLeftAlone) {
  Access access;
  std::array<int, 2> pipes{};
  ASSERT_EQ(pipe(pipes.data()), 0);
  const Descriptor read_end(pipes[0]), write_end(pipes[1]);
  access.NoteSubscriber(kBob.key, write_end.get());
  access.NoteSubscriber(kBob.key, -1);
  access.NoteSubscriber(kBob.key, 1 << 20);
  EXPECT_EQ(write(write_end.get(), "x", 1), 1);
}

}  // namespace
}  // namespace styled::security
