#include "clients/web/page.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/child.h"

namespace styled::web {
namespace {

TEST(PageTest, FilesAreFoundByTheirPathAndNothingElseIs) {
  const support::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "page/assets");
  support::WriteText(folder / "page/index.html", "<html>");
  support::WriteText(folder / "page/assets/a.js", "1");
  support::WriteText(folder / "secret.txt", "secret");
  const auto page = Page::Load(folder / "page");
  ASSERT_TRUE(page.ok()) << page.status().message();
  ASSERT_NE(page.value().Find("/"), nullptr);
  EXPECT_EQ(page.value().Find("/")->bytes, "<html>");
  EXPECT_EQ(page.value().Find("/?quality=low")->type, "text/html; charset=utf-8");
  EXPECT_FALSE(page.value().Find("/index.html")->forever);
  ASSERT_NE(page.value().Find("/assets/a.js"), nullptr);
  EXPECT_EQ(page.value().Find("/assets/a.js")->type, "text/javascript; charset=utf-8");
  EXPECT_TRUE(page.value().Find("/assets/a.js")->forever);
  for (const char* target :
       {"", "//", "/assets", "/assets/", "/../secret.txt", "/assets/../../secret.txt",
        "/%2e%2e/secret.txt", "secret.txt", "/index.html/"}) {
    EXPECT_EQ(page.value().Find(target), nullptr) << target;
  }
}

TEST(PageTest, AFolderThatIsNoPageIsRefused) {
  const support::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "empty");
  const auto empty = Page::Load(folder / "empty");
  ASSERT_FALSE(empty.ok());
  EXPECT_NE(empty.status().message().find("index.html"), std::string::npos);
  EXPECT_FALSE(Page::Load(folder / "none").ok());
  support::WriteText(folder / "file", "x");
  EXPECT_FALSE(Page::Load(folder / "file").ok());
}

}  // namespace
}  // namespace styled::web
