#include "tests/e2e/doctor/stage.h"

#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

namespace styled::support {

bool DoctorTest::own_network = false;

namespace {

bool Write(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.flush();
  return out.good();
}

bool RaiseLoopback() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::string("lo").copy(request.ifr_name, IFNAMSIZ - 1);
  bool ok = ioctl(fd, SIOCGIFFLAGS, &request) == 0;
  request.ifr_flags |= IFF_UP;
  ok = ok && ioctl(fd, SIOCSIFFLAGS, &request) == 0;
  close(fd);
  return ok;
}

}  // namespace

// Root needs no more; any other user first becomes root of a user namespace. A partial success
// would leave this process without any network, so a child tries it first.
bool EnterOwnNetwork() {
  const auto enter = [] {
    if (unshare(CLONE_NEWNET) == 0) return RaiseLoopback();
    const std::string uid = std::to_string(getuid()), gid = std::to_string(getgid());
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
    (void)Write("/proc/self/setgroups", "deny");
    return Write("/proc/self/uid_map", "0 " + uid + " 1") &&
           Write("/proc/self/gid_map", "0 " + gid + " 1") && RaiseLoopback();
  };
  const pid_t child = fork();
  if (child == 0) _exit(enter() ? 0 : 1);
  int status = 1;
  return child > 0 && waitpid(child, &status, 0) == child && status == 0 && enter();
}

bool Shell(const std::string& command) {
  return std::system(("PATH=$PATH:/usr/sbin:/sbin; " + command + " 2>/dev/null").c_str()) == 0;
}

std::uint16_t FreePort() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  close(fd);
  return ntohs(address.sin_port);
}

std::string Local(std::uint16_t port) { return "127.0.0.1:" + std::to_string(port); }

Streaming::Streaming(const std::string& address, double rate_hz, std::function<Bytes()> make)
    : thread_([=](const std::stop_token& stop) {
        const UdpLink link(address);
        while (!stop.stop_requested()) {
          link.Send(make());
          Sleep(1 / rate_hz);
        }
      }) {}

void DoctorTest::SetUpTestSuite() {
  static const bool entered = EnterOwnNetwork();
  own_network = entered;
}

const nlohmann::json& DoctorTest::Report::Finding(const std::string& finding) const {
  static const nlohmann::json kNone;
  for (const auto& entry : json["findings"]) {
    if (entry["code"] == finding) return entry;
  }
  ADD_FAILURE() << "no " << finding << " in " << text;
  return kNone;
}

std::string DoctorTest::Report::Of(const std::string& finding, const char* key) const {
  const auto& found = Finding(finding);
  return found.is_null() ? "" : found[key].get<std::string>();
}

DoctorTest::Report DoctorTest::Doctor(std::vector<std::string> arguments, bool capture) {
  const std::string out = folder_ / ("report" + std::to_string(runs_++) + ".json");
  std::string command = std::string("exec ") + STYLECTL_BINARY +
                        " --json --timeout 1 doctor --seconds 2" + (capture ? "" : " --no-capture");
  for (const auto& argument : arguments) command += " '" + argument + "'";
  Child child({"/bin/sh", "-c", command + " > '" + out + "'"}, folder_ / "stderr.txt");
  Report report;
  report.code = child.Wait(60).value_or(-1);
  report.text = ReadText(out);
  report.json = nlohmann::json::parse(report.text, nullptr, false);
  EXPECT_TRUE(report.json.is_object()) << report.text << ReadText(folder_ / "stderr.txt");
  if (!report.json.contains("findings")) return report;
  for (const auto& finding : report.json["findings"]) {
    if (finding["severity"] == "problem") report.problems.push_back(finding["code"]);
  }
  EXPECT_EQ(report.code, report.problems.empty() ? 0 : 1);
  return report;
}

std::string DoctorTest::Config(const std::string& type, const std::string& listen,
                               const std::string& keys) {
  const std::string file = folder_ / "styled.toml";
  WriteText(file, "[[source]]\nname = \"suit\"\ntype = \"" + type + "\"\nlisten = \"" + listen +
                      "\"\n" + keys + "\n[control]\naddress = \"tcp://" + Local(FreePort()) +
                      "\"\n");
  return file;
}

void DoctorTest::Play(const std::string& as, const std::string& to,
                      const std::vector<std::string>& arguments) {
  std::vector<std::string> all{STYLESIM_BINARY, "--as", as, "--to",
                               to.find("://") == to.npos ? "udp://" + to : to};
  all.insert(all.end(), arguments.begin(), arguments.end());
  players_.push_back(std::make_unique<Child>(all, folder_ / "stylesim.txt"));
}

}  // namespace styled::support
