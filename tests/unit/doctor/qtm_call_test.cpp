// A QTM that is only a socket of this machine's loopback.
#include "clients/doctor/qtm_call.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>

#include "tests/unit/qtm/decode_cases.h"

namespace styled::doctor {
namespace {

class QtmCallTest : public ::testing::Test {
 protected:
  QtmCallTest() : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_storage address;
    socklen_t size = ToSocket({"127.0.0.1", 0}, address);
    EXPECT_EQ(bind(listener_.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_.get(), 1), 0);
    getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size);
    call_ = std::move(MakeQtmCall(FromSocket(address), answers_).value());
    call_->Tick(1);
    server_ = Descriptor(accept(listener_.get(), nullptr, nullptr));
    call_->Tick(1);
  }
  static void Wait(int fd) {
    pollfd waiting{fd, POLLIN, 0};
    EXPECT_EQ(poll(&waiting, 1, 5000), 1);
  }
  // The requests of the call after that.
  std::string AskedAfter(const qtm::testing::Bytes& packet) {
    EXPECT_EQ(send(server_.get(), packet.data(), packet.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(packet.size()));
    Wait(call_->fd());
    call_->Listen(*notes_);
    Wait(server_.get());
    std::array<std::byte, 200> question;
    const ssize_t size = recv(server_.get(), question.data(), question.size(), MSG_DONTWAIT);
    if (size <= 0) return "nothing";
    qtm::Packet asked;
    EXPECT_EQ(qtm::DecodePacket(std::span(question).first(static_cast<std::size_t>(size)), asked),
              qtm::DecodeResult::kOk);
    return std::string(qtm::TextOf(asked.payload));
  }

  Descriptor listener_, server_;
  QtmAnswers answers_;
  std::unique_ptr<Notebook> notes_ = std::make_unique<Notebook>();
  std::unique_ptr<Listener> call_;
};

TEST_F(QtmCallTest, AsksInTurnWhateverTheCaseOfTheServersLetters) {
  using namespace qtm::testing;
  EXPECT_EQ(AskedAfter(Command("qtm rt interface CONNECTED.")), "Version 1.25");
  EXPECT_TRUE(answers_.greeted);
  EXPECT_EQ(AskedAfter(Error("Version NOT supported")), "Version 1.24");
  EXPECT_EQ(AskedAfter(Command("version SET TO 1.24")), "GetParameters Skeleton");
  EXPECT_EQ(answers_.minor, 24);
  EXPECT_EQ(AskedAfter(Xml(kFlatXml)), "StreamFrames Frequency:10 Skeleton");
  EXPECT_EQ(answers_.skeletons, 2U);
}

}  // namespace
}  // namespace styled::doctor
