// Pictures keep their bits: a change of the renderer's shape leaves every hash of recorded_pictures/ as it
// is.
//
// Bits belong to an arithmetic class (wire/arithmetic_class.h); each has a file there. Where pictures change
// rightly, the version in jobs.txt is raised and the hashes are recorded anew, on each kind of machine that
// is there:
//
//   TESSERA_RECORD_PICTURES=1 ctest -R recorded_pictures
//
// Files of an earlier version, and classes that have none, are skipped by name until then.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "integration/farm_under_test.h"
#include "render/renderer.h"
#include "wire/arithmetic_class.h"

namespace tessera::integration {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = "tests/integration/recorded_pictures";

struct RecordedLines {
  std::string version;             // the first line
  std::vector<std::string> lines;  // comments are left out
};

RecordedLines read_lines(const fs::path& file) {
  std::ifstream in{file};
  RecordedLines read;
  std::getline(in, read.version);
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.front() != '#') read.lines.push_back(line);
  }
  return read;
}

Arguments words_of(const std::string& line) {
  std::istringstream in{line};
  return {std::istream_iterator<std::string>{in}, {}};
}

/// One "hash job" a line.
std::vector<std::string> render_all(const std::vector<std::string>& jobs, const std::string& isa) {
  std::vector<std::string> hashes;
  for (const std::string& job : jobs) {
    hashes.push_back(expected_hash(words_of(job) + Arguments{"--isa", isa, "--quiet"}) + " " + job);
  }
  return hashes;
}

TEST(RecordedPictures, KeepTheirBits) {
  const RecordedLines jobs = read_lines(kFolder / "jobs.txt");
  ASSERT_GE(jobs.lines.size(), 12u);
  const std::vector<std::string> classes = render::arithmetic_classes(render::supported_isas());
  ASSERT_FALSE(classes.empty()) << "no kernels of this build";
  std::string skipped;
  for (const std::string& arithmetic_class : classes) {
    std::string name = arithmetic_class;
    std::replace(name.begin(), name.end(), '/', '_');
    const fs::path file = kFolder / (name + ".txt");
    const std::string isa{wire::isa_of(arithmetic_class)};
    if (std::getenv("TESSERA_RECORD_PICTURES") != nullptr) {
      std::ofstream out{file};
      out << jobs.version << '\n';
      for (const std::string& line : render_all(jobs.lines, isa)) out << line << '\n';
      continue;
    }
    const RecordedLines recorded = read_lines(file);
    if (recorded.version != jobs.version) {
      skipped += " " + arithmetic_class;
      continue;
    }
    EXPECT_EQ(render_all(jobs.lines, isa), recorded.lines) << "by " << arithmetic_class;
  }
  if (!skipped.empty()) GTEST_SKIP() << "no pictures of " << jobs.version << " were recorded by" << skipped;
}

}  // namespace
}  // namespace tessera::integration
