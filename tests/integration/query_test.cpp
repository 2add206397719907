// `tessera query` as users have it: options, files and pipes in; tables out; exit codes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "support/long_form.h"
#include "support/needs.h"
#include "support/picture/unpacked_corpus.h"
#include "support/process/process.h"
#include "support/process/temp_dir.h"

namespace tessera::integration::query {
namespace {

using support::Finished;
using testing::HasSubstr;

constexpr const char* kProgram = TESSERA_BIN_DIR "/tessera";
constexpr const char* kBox = "scenes/cornell-box/scene.pbrt";

Finished ask(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {kProgram, "query"});
  return support::run_program(std::move(arguments), std::chrono::minutes(5));
}

using Table = std::vector<std::vector<std::string>>;  // a row each, without the header

/// Rows of CSV without quoted line ends.
Table table(const std::string& text) {
  Table rows;
  for (const std::string& line : std::vector<std::string>(absl::StrSplit(text, '\n', absl::SkipEmpty()))) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        cells.emplace_back();
      else
        cells.back() += c;
    }
    rows.push_back(std::move(cells));
  }
  if (!rows.empty()) rows.erase(rows.begin());
  return rows;
}

class Query : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = directory_.path() / name;
    std::ofstream(path) << text;
    return path.string();
  }
  const support::TempDir directory_;
};

TEST_F(Query, TellsAllHitsOfARayThroughTheCornellBox) {
  const Finished done = ask({kBox, "--ray", "0,1,5,0,0,-1", "--quiet"});
  ASSERT_EQ(done.status.code, 0) << done.err;
  const Table rows = table(done.out);
  ASSERT_EQ(rows.size(), 3u);  // both sides of the tall block, and the back wall
  EXPECT_EQ(rows[0][7], "TallBox");
  EXPECT_EQ(rows[0][17], "entering");
  EXPECT_EQ(rows[1][7], "TallBox");
  EXPECT_EQ(rows[1][17], "leaving");
  EXPECT_EQ(rows[2][7], "BackWall");
  EXPECT_NEAR(std::stod(rows[2][8]), 6, 1e-6);
}

TEST_F(Query, AnswersTheSameOfAllFormats) {
  const std::string ball = R"(shapes { name: 'ball' sphere { radius: 1 } material: 'm' }
    materials { name: 'm' diffuse { } } camera { perspective { fov_degrees: 40 } } film { width: 8 height: 8 })";
  const std::string scenes[] = {
      write("s.textproto", ball),
      write("s.pbrt", "Camera \"perspective\"\nWorldBegin\nShape \"sphere\" \"float radius\" [1]\n"),
      write(
          "s.xml",
          "<scene version=\"3.0.0\"><sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/></sensor>"
          "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/></shape></scene>")};
  for (const std::string& scene : scenes) {
    const Finished done = ask({scene, "--ray", "-3,0,0,2,0,0", "--inside", "0.5,0,0", "--closest", "0,5,0",
                               "--format", "json", "--quiet"});
    ASSERT_EQ(done.status.code, 0) << scene << done.err;
    std::vector<nlohmann::json> rows;
    std::istringstream lines(done.out);
    for (std::string line; std::getline(lines, line);) rows.push_back(nlohmann::json::parse(line));
    ASSERT_EQ(rows.size(), 5u) << done.out;
    EXPECT_EQ(rows[0]["t"], 1);
    EXPECT_EQ(rows[1]["t"], 2);
    EXPECT_EQ(rows[1]["side"], "leaving");
    EXPECT_EQ(rows[2]["side"], "inside");
    EXPECT_EQ(rows[3]["winding"], 1);
    EXPECT_EQ(rows[4]["t"], 4);
    EXPECT_EQ(rows[4]["y"], 1);
    EXPECT_EQ(rows[4]["query"], 3);
  }
}

TEST_F(Query, GoesOnAfterLinesThatItCannotRead) {
  const std::string lines = write("q.txt",
                                  "# points\ninside 0 0 0\ninside nan 0 0\nray 0 0 0 0 0 0\n\nray 1 2\n"
                                  "inside 1e308 0 0\ninside 0 0.5 0\n");
  const Finished done = ask({kBox, "--queries", lines, "--quiet"});
  EXPECT_EQ(done.status.code, 2);
  EXPECT_THAT(done.err, HasSubstr(absl::StrCat(lines, ":3:8: 'nan' is not a finite number")));
  EXPECT_THAT(done.err, HasSubstr(":4:15: the direction has no length"));
  EXPECT_THAT(done.err, HasSubstr(":6:8: expected 6 numbers; there are 2"));
  EXPECT_THAT(done.err, HasSubstr(":7:8: '1e308' is beyond 1e18"));
  std::vector<std::string> answered;
  for (const auto& row : table(done.out)) {
    if (row[2] == "0") answered.push_back(row[0]);
  }
  EXPECT_EQ(answered, (std::vector<std::string>{"1", "6"}));  // numbers count those that were not read
}

TEST_F(Query, RefusesWhatItCannotBeAsked) {
  EXPECT_EQ(ask({kBox}).status.code, 2);
  EXPECT_EQ(ask({kBox, "--bounds", "--watertight"}).status.code, 2);
  EXPECT_EQ(ask({kBox, "--ray", "1,2,3"}).status.code, 2);
  EXPECT_EQ(ask({kBox, "--inside", "0,0,inf"}).status.code, 2);
  EXPECT_EQ(ask({kBox, "--bounds", "--time", "2"}).status.code, 2);
  EXPECT_EQ(ask({kBox, "--bounds", "--format", "xml"}).status.code, 2);
  EXPECT_EQ(ask({kBox, "--queries", "/no/such/file"}).status.code, 2);
  EXPECT_EQ(ask({kBox, "--queries", "scenes"}).status.code, 2);  // a folder
  EXPECT_EQ(ask({"/no/such/scene.pbrt", "--bounds"}).status.code, 2);
  EXPECT_EQ(ask({write("bad.pbrt", "Shape \"sphere\" [\n"), "--bounds"}).status.code, 3);
}

TEST_F(Query, HasTablesOfBoundsAndDefects) {
  const Finished bounds = ask({kBox, "--bounds", "--quiet", "--origin", "0,0,0"});
  ASSERT_EQ(bounds.status.code, 0) << bounds.err;
  const Table rows = table(bounds.out);
  ASSERT_GT(rows.size(), 5u);
  EXPECT_EQ(rows[0][0], "");  // the scene
  EXPECT_NEAR(std::stod(rows[0][3]), -1, 1e-6);
  EXPECT_NEAR(std::stod(rows[0][7]), 2, 0.1);
  EXPECT_EQ(rows[0][9], "yes");

  const Finished defects = ask({kBox, "--watertight", "--quiet"});
  ASSERT_EQ(defects.status.code, 0) << defects.err;
  int open = 0, shapes = 0;
  for (const auto& row : table(defects.out)) open += row[7] == "open-edge", shapes += row[7].empty();
  EXPECT_GE(open, 4 * 5);  // the walls are quadrilaterals
  EXPECT_EQ(shapes, static_cast<int>(rows.size()) - 1);
}

/// Rays from about a scene's middle, to all sides.
std::string rays(int count) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += "ray";
    for (int k = 0; k < 6; ++k) absl::StrAppend(&text, " ", normal(random));
    text += '\n';
  }
  return text;
}

/// Many rays through a pipe are answered in their order, and as they are by themselves.
TEST_F(Query, AnswersAPipeInOrder) {
  const int count = test::long_form() ? 1'000'000 : 20'000;
  std::string scene = kBox;
  std::optional<test::CorpusFolder> corpus;
  if (test::long_form()) {
    corpus = test::find_corpus("pbrt/classroom");
    if (!corpus) GTEST_SKIP() << test::needs("the corpus' pbrt/classroom");
    scene = (corpus->path() / "scene.pbrt").string();
  }
  const std::string file = write("rays.txt", rays(count)), answers = (directory_.path() / "answers").string();
  const Finished done = support::run_program({"/bin/sh", "-c",
                                              absl::StrCat("cat ", file, " | ", kProgram, " query ", scene,
                                                           " --queries - --quiet --threads 2 > ", answers)},
                                             std::chrono::minutes(20));
  ASSERT_EQ(done.status.code, 0) << done.err;
  std::ifstream in(answers);
  std::string line;
  std::getline(in, line);
  int query = 0, hits = 0, row = 0;
  double t = 0;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = table("header\n" + line)[0];
    if (std::stoi(cells[0]) != query) {
      ASSERT_EQ(std::stoi(cells[0]), ++query);
      row = 0, t = 0;
    }
    if (cells[2] == "0") continue;
    ASSERT_EQ(std::stoi(cells[2]), ++row);
    ASSERT_GE(std::stod(cells[8]), t);
    t = std::stod(cells[8]);
    ++hits;
  }
  EXPECT_EQ(query, count);
  EXPECT_GT(hits, count / 4);
}

}  // namespace
}  // namespace tessera::integration::query
