// Requests that take little on the wire and much in memory.
#include "daemon/control/request_size.h"

#include <gtest/gtest.h>

#include <string>

#include "daemon/control/control_socket.h"
#include "proto/styled/v1/control.pb.h"
#include "tests/support/count_new.h"

namespace styled::control {
namespace {

constexpr std::size_t kMemoryPerByte = 8, kFixed = std::size_t{4} << 20;

std::span<const std::byte> Bytes(const std::string& text) { return std::as_bytes(std::span(text)); }
std::size_t Beside(const v1::Request& request) {
  return SizeOfRequest(Bytes(request.SerializeAsString())).beside_file;
}

TEST(RequestSize, AFileIsLeftOut) {
  const std::string file(1'000'000, 'x');
  v1::Request like, import, restore, set;
  like.mutable_like()->set_name("a");
  like.mutable_like()->set_clip(file);
  EXPECT_LT(Beside(like), 20U);
  import.mutable_import_style()->set_file(file);
  EXPECT_LT(Beside(import), 20U);
  auto& checkpoint = *restore.mutable_restore_checkpoint()->mutable_checkpoint();
  checkpoint.set_state(file);
  EXPECT_LT(Beside(restore), 20U);
  EXPECT_TRUE(SizeOfRequest(Bytes(restore.SerializeAsString())).has_checkpoint);
  EXPECT_FALSE(SizeOfRequest(Bytes(like.SerializeAsString())).has_checkpoint);

  like.mutable_like()->set_file(file);
  import.mutable_import_style()->set_name(file);
  checkpoint.set_performer(file);
  set.mutable_set()->set_preset(file);
  for (const v1::Request* const request : {&like, &import, &restore, &set}) {
    EXPECT_GT(Beside(*request), 1'000'000U);
  }
}

TEST(RequestSize, AnInvalidMessageIsCounted) {
  v1::Request like;
  like.mutable_like()->set_clip(std::string(100'000, 'x'));
  const std::string bytes = like.SerializeAsString();
  for (const std::string& broken :
       {std::string(100'000, '\xFF'), std::string(100'000, '\0'), std::string(100'000, '\x0b'),
        bytes.substr(0, 90'000), std::string(90'000, '\x07') + bytes}) {
    EXPECT_GE(SizeOfRequest(Bytes(broken)).beside_file, 80'000U);
  }
  EXPECT_EQ(SizeOfRequest({}).beside_file, 0U);
}

// Accepted requests use memory in proportion; refused ones are refused before they are parsed.
TEST(RequestSize, AcceptedRequestsUseMemoryInProportion) {
  const std::string clip(4 << 20, 'x');
  for (const int entries : {30'000, 2'000'000}) {
    v1::Request like, restore, set;
    like.mutable_like()->set_clip(clip);
    auto& look = *restore.mutable_restore_checkpoint()->mutable_checkpoint()->mutable_look();
    for (int i = 0; i < entries; ++i) look.add_mix();
    restore.mutable_restore_checkpoint()->mutable_checkpoint()->set_state("x");
    for (int i = 0; i < entries; ++i) set.mutable_set()->add_mix();
    for (const v1::Request* const request : {&like, &restore, &set}) {
      const std::string bytes = request->SerializeAsString();
      const RequestSize size = SizeOfRequest(Bytes(bytes));
      if (size.beside_file > MostBesideFile(size)) {
        EXPECT_EQ(entries, 2'000'000) << "of this many it may have";
        continue;
      }
      const support::CountNew count;
      v1::Request parsed;
      EXPECT_TRUE(parsed.ParseFromString(bytes));
      EXPECT_LE(count.peak_bytes(), kMemoryPerByte * bytes.size() + kFixed) << bytes.size();
    }
  }
}

}  // namespace
}  // namespace styled::control
