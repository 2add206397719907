#include "command/setup/config_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace tessera::client {
namespace {

using ::testing::HasSubstr;

class ConfigFile : public ::testing::Test {
 protected:
  ~ConfigFile() override { std::filesystem::remove(path_); }
  absl::StatusOr<std::vector<ConfigValue>> read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_config(path_);
  }
  std::string fault(const std::string& text) {
    const auto config = read(text);
    EXPECT_TRUE(absl::IsInvalidArgument(config.status())) << config.status();
    return std::string{config.status().message()};
  }
  const std::string path_ =
      std::filesystem::temp_directory_path() / ("config-" + std::to_string(::getpid()) + ".toml");
};

TEST_F(ConfigFile, GivesACommandItsOwnOptionsAfterTheGeneralOnes) {
  const auto config = read(
      "server = \"host:1\"\nallow-insecure = true\n[defaults]\nthreads = 3\nspp = 8\n"
      "[render]\nspp = 64\naov = [\"depth\", \"normal\"]\n");
  ASSERT_TRUE(config.ok()) << config.status();
  std::vector<std::string> told;
  for (const options::FileValue& value : values_for("render", *config))
    told.push_back(value.option + "=" + value.text + (value.expected ? "!" : ""));
  EXPECT_THAT(told, ::testing::ElementsAre("--allow-insecure=true", "--spp=8", "--threads=3",
                                           "--server=host:1", "--aov=depth,normal!", "--spp=64!"));
  for (const options::FileValue& value : values_for("jobs", *config)) EXPECT_FALSE(value.expected);
}

TEST_F(ConfigFile, NamesTheLineOfAFault) {
  EXPECT_THAT(fault("server = \"a:1\"\ntls = [\n"), HasSubstr(path_ + ":"));
  EXPECT_THAT(fault("\n\nserfer = \"a:1\"\n"), HasSubstr(path_ + ":3: there is no setting 'serfer'"));
  EXPECT_THAT(fault("[render]\nspp = 1979-05-27\n"), HasSubstr(path_ + ":2: render.spp: a text"));
  EXPECT_THAT(fault("[render.deep]\nspp = 1\n"), HasSubstr("render.deep"));
  EXPECT_THAT(fault(std::string(2 << 20, '#')), HasSubstr("more than 1048576 bytes"));
}

TEST_F(ConfigFile, IsEmptyWhereThereIsNone) {
  const auto config = read_config("/nowhere/config.toml");
  ASSERT_TRUE(config.ok());
  EXPECT_TRUE(config->empty());
}

TEST(ConfigSetting, ChangesOneLineAndLeavesTheOthers) {
  const std::string text = "# mine\nserver = \"a:1\"\n\n[render]\n# spp = 1\nspp = 2 # two\n";
  EXPECT_EQ(*with_setting(text, "server", "b:2"),
            "# mine\nserver = \"b:2\"\n\n[render]\n# spp = 1\nspp = 2 # two\n");
  EXPECT_EQ(*with_setting(text, "render.spp", "64"),
            "# mine\nserver = \"a:1\"\n\n[render]\n# spp = 1\nspp = 64\n");
  EXPECT_EQ(*with_setting("# server = \"example:1\"\n# more\n", "server", "b:2"),
            "# server = \"example:1\"\nserver = \"b:2\"\n# more\n");
  EXPECT_EQ(*with_setting(text, "tls", "x \"y\""),
            "# mine\nserver = \"a:1\"\n\ntls = \"x \\\"y\\\"\"\n[render]\n# spp = 1\nspp = 2 # two\n");
  EXPECT_EQ(*with_setting("", "defaults.threads", "8"), "[defaults]\nthreads = 8\n");
  EXPECT_EQ(*with_setting("", "render.aov", "[\"depth\", \"normal\"]"),
            "[render]\naov = [\"depth\", \"normal\"]\n");
  EXPECT_EQ(*with_setting("", "tls", "[1]]"), "tls = \"[1]]\"\n");
  EXPECT_EQ(*with_setting("", "render.crop", "0,0,8,8"), "[render]\ncrop = \"0,0,8,8\"\n");
  EXPECT_FALSE(with_setting(text, "a.b.c", "1").ok());
  EXPECT_FALSE(with_setting(text, "tls", "1\nspp = 2").ok());
  EXPECT_FALSE(with_setting(text, "colour", "1").ok());
}

}  // namespace
}  // namespace tessera::client
