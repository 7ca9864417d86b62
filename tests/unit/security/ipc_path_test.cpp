#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>

#include "proto/ipc/path.h"
#include "tests/support/child.h"

namespace styled::ipc {
namespace {

using testing::HasSubstr;

// A socket at `path`.
int Bind(const std::string& path, int type, bool listening) {
  const int fd = socket(AF_UNIX, type | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  EXPECT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  if (listening) EXPECT_EQ(listen(fd, 1), 0);
  return fd;
}

TEST(IpcPathTest, AFreePathAndADeadSocketMayBeBound) {
  const support::TemporaryFolder folder;
  EXPECT_TRUE(CheckFree(folder / "free").ok());
  EXPECT_TRUE(CheckFree("@abstract").ok()) << "has no file";
  close(Bind(folder / "dead", SOCK_STREAM, true));
  EXPECT_TRUE(CheckFree(folder / "dead").ok());
}

TEST(IpcPathTest, OtherFilesThanSocketsAreNamed) {
  const support::TemporaryFolder folder;
  support::WriteText(folder / "file", "precious");
  std::filesystem::create_directory(folder / "folder");
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::filesystem::create_symlink(folder / "file", folder / "link");
  for (const auto& [name, found] :
       {std::pair{"file", "an ordinary file"}, std::pair{"folder", "a folder"},
        std::pair{"pipe", "a pipe or a device"}, std::pair{"link", "a symbolic link"}}) {
    for (const Status& status : {CheckKind(folder / name), CheckFree(folder / name)}) {
      ASSERT_FALSE(status.ok()) << name;
      EXPECT_THAT(status.message(),
                  HasSubstr(std::string("there is ") + found + "; expected a free path"));
    }
  }
  EXPECT_EQ(support::ReadText(folder / "file"), "precious");
}

TEST(IpcPathTest, ASocketInUseIsRefused) {
  const support::TemporaryFolder folder;
  for (const int type : {SOCK_STREAM, SOCK_DGRAM}) {
    const std::string path = folder / std::to_string(type);
    const int fd = Bind(path, type, type == SOCK_STREAM);
    EXPECT_TRUE(CheckKind(path).ok());
    EXPECT_THAT(CheckFree(path).message(), HasSubstr("in use by another program"));
    close(fd);
  }
}

}  // namespace
}  // namespace styled::ipc
