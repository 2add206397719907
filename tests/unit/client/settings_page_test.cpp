#include "command/settings_page.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace tessera::client {
namespace {

TEST(SettingsPage, TheDocumentInTheRepositoryIsTheProgramsOwn) {
  std::stringstream document;
  document << std::ifstream("docs/settings.md").rdbuf();
  EXPECT_EQ(document.str(), settings_document()) << "tessera settings --document > docs/settings.md";
}

}  // namespace
}  // namespace tessera::client
