// Show control: cues by timecode and by name, and OSC.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <span>

#include "daemon/looks/cues.h"
#include "proto/rigs/vmc/osc.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

std::string Cue(const std::string& name, const std::string& more) {
  return "[[cue]]\nname = \"" + name + "\"\n" + more;
}

TEST(ShowTest, ACueIsFiredByNameAndAWrongOneIsNamed) {
  Daemon daemon({}, Cue("entrance", "style = \"style2\"\nstrength = 0.5\n") +
                        Cue("blackout", "panic = true\n") +
                        Cue("hers", "performer = \"rig.anna\"\nclear = true\n"));
  ControlClient control(daemon.control);
  Rig rig("anna");
  const UdpLink link(daemon.udp);
  link.Send(rig.Body());
  Paced(10, 120, [&](int) { link.Send(rig.Frame()); });
  v1::Request request;
  request.mutable_cue()->set_name("entrance");
  const auto fired = control.Ask(request);
  ASSERT_EQ(fired.code(), v1::CODE_OK) << fired.reason();
  ASSERT_EQ(fired.applied_size(), 1);
  EXPECT_EQ(control.Performer("rig.anna").styles(0).style(), "style2");
  EXPECT_EQ(control.Performer("rig.anna").strength(), 0.5F);
  v1::Request pin;
  pin.set_performer("rig.anna");
  pin.mutable_pin()->set_pinned(true);
  ASSERT_EQ(control.Ask(pin).code(), v1::CODE_OK);
  const auto passed_over = control.Ask(request);
  EXPECT_EQ(passed_over.code(), v1::CODE_OK) << "of everyone: the pinned one is passed over";
  request.mutable_cue()->set_name("hers");
  const auto pinned = control.Ask(request);
  EXPECT_EQ(pinned.code(), v1::CODE_PINNED);
  EXPECT_EQ(pinned.reason(), "cue hers: rig.anna: pinned; unpin them first");
  request.mutable_cue()->set_name("blackout");
  EXPECT_EQ(control.Ask(request).code(), v1::CODE_OK);
  EXPECT_EQ(control.Performer("rig.anna").styles_size(), 0);
  request.mutable_cue()->set_name("exit");
  const auto refused = control.Ask(request);
  EXPECT_EQ(refused.code(), v1::CODE_UNKNOWN_CUE);
  EXPECT_EQ(refused.reason(), "no cue \"exit\"; the cues are entrance blackout hers");
  v1::Request list;
  list.mutable_list();
  EXPECT_EQ(control.Ask(list).list().cues_size(), 3);
}

// A lighting console: sends OSC and receives replies.
class Console {
 public:
  explicit Console(const std::string& address) : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    const std::size_t colon = address.rfind(':');
    inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr);
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
    EXPECT_EQ(connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    const timeval wait{10, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
  }
  ~Console() { close(fd_); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void Send(const std::string& address, const std::string& text, float number) const {
    std::array<std::byte, 256> bytes;
    vmc::osc::Writer writer(bytes);
    writer.BeginMessage(address, "sf");
    writer.Text(text);
    writer.Float(number);
    writer.EndMessage();
    ASSERT_EQ(send(fd_, bytes.data(), writer.size(), 0), static_cast<ssize_t>(writer.size()));
  }
  void SendRaw(const std::string& bytes) const { (void)send(fd_, bytes.data(), bytes.size(), 0); }
  // Address and reason of the next error message.
  std::pair<std::string, std::string> Error() const {
    std::array<std::byte, 2048> bytes;
    const ssize_t size = recv(fd_, bytes.data(), bytes.size(), 0);
    if (size < 0) return {"", "nothing came"};
    vmc::osc::Reader reader(
        std::span<const std::byte>(bytes.data(), static_cast<std::size_t>(size)));
    vmc::osc::Message message;
    EXPECT_EQ(reader.Next(message), vmc::osc::Reader::Step::kMessage);
    EXPECT_EQ(message.address, "/styled/error");
    vmc::osc::Arguments arguments(message);
    std::string_view address, reason;
    EXPECT_TRUE(arguments.Text(address) && arguments.Text(reason));
    return {std::string(address), std::string(reason)};
  }

 private:
  int fd_;
};

TEST(ShowTest, AConsoleSteersByOscAndHearsWhatIsRefused) {
  Daemon daemon({"osc.listen=\"127.0.0.1:0\""});
  ASSERT_FALSE(daemon.osc.empty());
  ControlClient control(daemon.control);
  Rig rig("anna");
  const UdpLink link(daemon.udp);
  link.Send(rig.Body());
  Paced(10, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_GT(control.CounterSoon("pipeline.frames", 10), 0U);

  const Console console(daemon.osc);
  console.Send("/styled/rig.anna/style", "style3", 0.75F);
  EXPECT_EQ(control.CounterSoon("control.osc", 1), 1U);
  EXPECT_EQ(control.Performer("rig.anna").styles(0).style(), "style3");
  EXPECT_EQ(control.Performer("rig.anna").strength(), 0.75F);

  console.Send("/styled/rig.anna/style", "pirate", 1);
  auto error = console.Error();
  EXPECT_EQ(error.first, "/styled/rig.anna/style");
  EXPECT_NE(error.second.find("pirate"), std::string::npos) << error.second;
  console.Send("/styled/rig.anna/dance", "x", 1);
  EXPECT_NE(console.Error().second.find("one of style, mix"), std::string::npos);
  console.SendRaw("no osc at all");
  EXPECT_NE(console.Error().second.find("is not OSC"), std::string::npos);
  EXPECT_EQ(control.Performer("rig.anna").styles(0).style(), "style3") << "nothing changed";
  EXPECT_NE(daemon.Log().find("OSC /styled/rig.anna/style"), std::string::npos) << daemon.Log();
}

TEST(ShowTest, OscOnTheNetworkTakesAKeyThatSaysSo) {
  TemporaryFolder folder;
  Child styled({Binary(), "--set", "osc.listen=\"0.0.0.0:0\"", "--set",
                "source.0.listen=\"127.0.0.1:0\"", "--set", "source.1.listen=\"127.0.0.1:0\""},
               folder / "err.txt");
  EXPECT_NE(styled.Wait(10), 0);
  EXPECT_NE(ReadText(folder / "err.txt").find("osc.allow_unauthenticated_remote = true"),
            std::string::npos)
      << ReadText(folder / "err.txt");
}

}  // namespace
}  // namespace styled::support
