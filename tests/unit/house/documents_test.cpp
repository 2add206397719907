// The documents say what is so: the files that they name are there, and the lists of integrators are whole.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "wire/algorithm.h"

namespace {

namespace fs = std::filesystem;

/// Every way to name a file of the sources, by its path or by the end of it: "server/store/file.h",
/// "store/file.h", "file.h".
std::set<std::string> names_of_files() {
  std::set<std::string> names;
  for (const char* top :
       {".ci", "proto", "lib", "server", "worker", "client", "tests", "deploy", "docs", "scenes", "python"}) {
    for (const auto& entry : fs::recursive_directory_iterator(top)) {
      if (!entry.is_regular_file()) continue;
      fs::path rest = entry.path();
      for (;;) {
        names.insert(rest.string());
        if (!rest.has_parent_path()) break;
        fs::path shorter;
        for (auto part = std::next(rest.begin()); part != rest.end(); ++part) shorter /= *part;
        rest = shorter;
      }
    }
  }
  return names;
}

TEST(Documents, FilesThatTheyNameAreThere) {
  // `path/name.extension` in backquotes, or `path/name.*`. Names without a folder may be of users' files,
  // NAME stands for any.
  static const std::regex pattern("`([A-Za-z0-9_.-]+/[A-Za-z0-9_./-]+\\.(h|cpp|proto|sh|cmake|py|\\*))`");
  const std::set<std::string> names = names_of_files();
  std::set<fs::path> documents{"README.md", "CONTRIBUTING.md"};
  for (const auto& entry : fs::recursive_directory_iterator("docs")) {
    if (entry.path().extension() == ".md") documents.insert(entry.path());
  }
  std::size_t seen = 0;
  for (const fs::path& document : documents) {
    std::ifstream in(document);
    std::size_t number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      for (auto found = std::sregex_iterator(line.begin(), line.end(), pattern);
           found != std::sregex_iterator(); ++found) {
        const std::string name = (*found)[1];
        if (name.find("NAME") != std::string::npos) continue;
        ++seen;
        const bool any = name.ends_with(".*");
        const std::string stem = name.substr(0, name.size() - (any ? 1 : 0));
        const auto known = any ? names.lower_bound(stem) : names.find(name);
        EXPECT_TRUE(known != names.end() && known->starts_with(stem))
            << document << ":" << number << ": there is no " << name;
      }
    }
  }
  EXPECT_GT(seen, 50u);  // the test reads what it believes it reads
}

TEST(Documents, IntegratorsAreThoseOfTheTable) {
  std::ifstream in("docs/command-line.md");
  std::string heading, documented, expected;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#")) heading = line;
    if (heading == "### Integrators" && line.starts_with("| `")) absl::StrAppend(&documented, line, "\n");
  }
  for (const tessera::wire::AlgorithmTraits& algorithm : tessera::wire::algorithms()) {
    EXPECT_STRNE(algorithm.summary, "") << algorithm.name;
    absl::StrAppend(&expected, "| `", algorithm.name, "` | ", algorithm.summary, " | ",
                    tessera::wire::word_of(algorithm.bias), " |\n");
  }
  EXPECT_EQ(documented, expected);
}

}  // namespace
