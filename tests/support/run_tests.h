// Runs GoogleTest's tests, all or those of some sources, and tells what was skipped: a program whose tests
// were all skipped has not passed.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace tessera::test {

/// CTest's SKIP_RETURN_CODE.
inline constexpr int kSkipped = 77;

/// Appends a line to the file that TESSERA_SKIPS names, if any; programs that run at once do not cut each
/// other's lines.
inline void note_skip(std::string line) {
  const char* const path = std::getenv("TESSERA_SKIPS");
  if (path == nullptr) return;
  for (char& c : line) {
    if (c == '\n') c = ' ';
  }
  line += '\n';
  const int file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) return;
  [[maybe_unused]] const ssize_t written = write(file, line.data(), line.size());
  close(file);
}

/// Notes what was skipped, with its reason.
inline void note_skips(const std::string& name, const testing::TestResult& result) {
  for (int i = 0; i < result.total_part_count(); ++i) {
    const testing::TestPartResult& part = result.GetTestPartResult(i);
    if (part.skipped()) note_skip(name + ": " + part.message());
  }
}

/// Filters tests by the source that they are in: "--sources=a_test.cpp,b_test.cpp", which is how CTest runs
/// the tests of one entry where a program has those of several. False if a source has no test.
inline bool select_sources(std::string_view sources) {
  std::string filter;
  while (!sources.empty()) {
    const std::string_view source = sources.substr(0, sources.find(','));
    sources.remove_prefix(std::min(source.size() + 1, sources.size()));
    const std::size_t before = filter.size();
    const testing::UnitTest& unit = *testing::UnitTest::GetInstance();
    for (int s = 0; s < unit.total_test_suite_count(); ++s) {
      const testing::TestSuite& suite = *unit.GetTestSuite(s);
      for (int t = 0; t < suite.total_test_count(); ++t) {
        const testing::TestInfo& test = *suite.GetTestInfo(t);
        const std::string_view file = test.file();
        if (file.substr(file.rfind('/') + 1) == source)
          filter += std::string(suite.name()) + "." + test.name() + ":";
      }
    }
    if (filter.size() == before) {
      std::fprintf(stderr, "no test is in %s\n", std::string(source).c_str());
      return false;
    }
  }
  testing::GTEST_FLAG(filter) = filter;
  return true;
}

/// Returns the program's exit code. The arguments are what InitGoogleTest() has left.
inline int run_tests(int argc, char** argv) {
  constexpr std::string_view kSources = "--sources=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with(kSources) && !select_sources(argument.substr(kSources.size())))
      return EXIT_FAILURE;
  }
  const int result = RUN_ALL_TESTS();
  const testing::UnitTest& unit = *testing::UnitTest::GetInstance();
  note_skips(program_invocation_short_name, unit.ad_hoc_test_result());
  for (int s = 0; s < unit.total_test_suite_count(); ++s) {
    const testing::TestSuite& suite = *unit.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t) {
      const testing::TestInfo& test = *suite.GetTestInfo(t);
      note_skips(std::string(suite.name()) + "." + test.name(), *test.result());
    }
  }
  const bool all_skipped = unit.test_to_run_count() > 0 && unit.successful_test_count() == 0;
  return result == 0 && all_skipped ? kSkipped : result;
}

}  // namespace tessera::test
