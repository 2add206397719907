// Runs every file of tests/scenario/farm. With TESSERA_REWRITE=1 in the environment, writes the outputs into
// the files instead, for a person to read through.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "scenario/scenario_runner.h"

namespace tessera::server {
namespace {

const std::filesystem::path kScenarios = "tests/scenario/farm";

struct Block {
  int line = 0;      // line of the first command
  std::string text;  // commands and comments as they are
  std::vector<std::string> commands;
  std::string expected;
};

std::vector<Block> read_blocks(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Block> blocks;
  Block block;
  bool in_output = false;
  int number = 0;
  const auto finish = [&] {
    if (!block.text.empty()) blocks.push_back(block);
    block = {};
    in_output = false;
  };
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (in_output && line.empty()) {
      finish();
    } else if (in_output) {
      block.expected += line + "\n";
    } else if (line == "----") {
      in_output = true;
    } else if (!line.empty()) {
      block.text += line + "\n";
      if (line[0] == '#') continue;
      if (block.commands.empty()) block.line = number;
      block.commands.push_back(line);
    }
  }
  finish();
  return blocks;
}

class Scenario : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(Scenario, GoesAsWritten) {
  const bool rewrite = std::getenv("TESSERA_REWRITE") != nullptr;
  const std::vector<Block> blocks = read_blocks(GetParam());
  ASSERT_FALSE(blocks.empty());
  ScenarioRunner runner;
  std::ostringstream rewritten;
  for (const Block& block : blocks) {
    std::string output;
    for (const std::string& command : block.commands) output += runner.run(command);
    rewritten << (rewritten.tellp() > 0 ? "\n" : "") << block.text << "----\n" << output;
    if (!rewrite) {
      EXPECT_EQ(output, block.expected) << GetParam().string() << ":" << block.line << "\n" << block.text;
    }
  }
  if (rewrite) std::ofstream(GetParam()) << rewritten.str();
}

std::vector<std::filesystem::path> scenarios() {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(kScenarios, error))
    paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

INSTANTIATE_TEST_SUITE_P(Farm, Scenario, testing::ValuesIn(scenarios()),
                         [](const auto& scenario) { return scenario.param.stem().string(); });

// The working directory is the source tree: an empty suite would pass without having looked.
TEST(Scenarios, AreFound) { EXPECT_GE(scenarios().size(), 10u); }

}  // namespace
}  // namespace tessera::server
