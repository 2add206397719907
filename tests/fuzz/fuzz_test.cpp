// Every target on its corpus, and on deterministic mutations of it: whatever comes, the code under test
// returns.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fuzz/cases.h"
#include "gtest/gtest.h"

namespace tessera::fuzz {
namespace {

namespace fs = std::filesystem;

struct Input {
  std::string file, bytes;
};

/// Corpus of a target, by name. Files called "sound-..." must be accepted.
std::vector<Input> corpus_of(const Target& target) {
  std::vector<Input> inputs;
  for (const auto& entry : fs::directory_iterator(fs::path("tests/fuzz/corpus") / target.name)) {
    std::ifstream file(entry.path(), std::ios::binary);
    inputs.push_back({entry.path().filename().string(), {std::istreambuf_iterator<char>(file), {}}});
  }
  std::sort(inputs.begin(), inputs.end(), [](const Input& a, const Input& b) { return a.file < b.file; });
  return inputs;
}

class Fuzz : public testing::TestWithParam<Case> {};

TEST_P(Fuzz, TheCorpus) {
  bool any_sound = false;
  for (const Input& input : corpus_of(*GetParam().target)) {
    const bool accepted = GetParam().target->accepts(input.bytes);
    // Else the mutations would only ever meet the first error.
    if (!input.file.starts_with("sound")) continue;
    EXPECT_TRUE(accepted) << input.file;
    any_sound = true;
  }
  EXPECT_TRUE(any_sound);
}

TEST_P(Fuzz, Mutations) {
  const Target& target = *GetParam().target;
  std::vector<Input> sound = corpus_of(target);
  std::erase_if(sound, [](const Input& input) { return !input.file.starts_with("sound"); });
  ASSERT_FALSE(sound.empty());
  std::mt19937 random(1);
  for (int i = 0; i < GetParam().mutations; ++i) {
    const std::string& bytes = sound[static_cast<std::size_t>(i) % sound.size()].bytes;
    target.accepts(target.mutate != nullptr ? target.mutate(bytes, random) : mutate_bytes(bytes, random));
  }
}

INSTANTIATE_TEST_SUITE_P(Target, Fuzz, testing::ValuesIn(cases()),
                         [](const auto& instance) { return std::string(instance.param.target->name); });

}  // namespace
}  // namespace tessera::fuzz
