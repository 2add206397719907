// Bad numbers in every place of text files that has a number: refused with file and line, or a finite
// picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>
#include <vector>

#include "stress/input/input_judge.h"
#include "stress/input/number_sites.h"
#include "stress/input/sample_files.h"
#include "support/long_form.h"
#include "support/needs.h"
#include "support/picture/unpacked_corpus.h"
#include "support/process/temp_dir.h"

namespace tessera::stress {
namespace {

const std::filesystem::path kSamples = "tests/stress/input";

struct Case {
  NumberSite site;
  std::string_view number;
};

/// Every bad number at every place, shuffled (the same way always), and the first `most` of those; ten times
/// as many in the long form.
std::vector<Case> cases_of(std::string_view text, TextKind kind, std::size_t most) {
  std::vector<Case> cases;
  for (const NumberSite site : number_sites(text, kind)) {
    for (const std::string_view number : kBadNumbers) cases.push_back({site, number});
  }
  std::mt19937 random(1);
  for (std::size_t i = cases.size(); i > 1; --i) std::swap(cases[i - 1], cases[random() % i]);
  cases.resize(std::min(cases.size(), test::long_form() ? 10 * most : most));
  return cases;
}

/// The line of `text` that a case is in, as it then reads.
std::string line_of(const std::string& text, std::size_t at) {
  const std::size_t begin = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
  return text.substr(begin, std::min(text.find('\n', at), text.size()) - begin);
}

/// All cases of one text, which stands in the file `bad` that `scene` (the same, or one that refers to it) is
/// read with.
void walk(const std::string& text, TextKind kind, const std::filesystem::path& bad,
          const std::filesystem::path& scene, std::size_t most) {
  InputJudge judge;
  const bool same = bad == scene;
  const auto complaint_about = [&](const std::string& changed) {
    write_bytes(bad, changed);
    return judge.judge_file(scene, same ? std::filesystem::path{} : bad);
  };
  ASSERT_EQ(complaint_about(text), "") << "the file as it is";
  ASSERT_EQ(judge.tally().rendered, 1u) << "the file as it is must be taken";
  const std::vector<Case> cases = cases_of(text, kind, most);
  int complaints = 0;
  for (const Case& c : cases) {
    const std::string changed = with_number(text, c.site, c.number);
    const std::string complaint = complaint_about(changed);
    if (complaint.empty()) continue;
    ADD_FAILURE() << line_of(changed, c.site.begin) << "\n  " << c.number << ": " << complaint;
    if (++complaints == 40) break;
  }
  std::printf("%s of %zu: %s\n", bad.filename().c_str(), cases.size(), judge.tally().to_string().c_str());
}

class InputNumbers : public testing::Test {
 protected:
  std::filesystem::path in_folder(const char* name) const { return folder_.path() / name; }

 private:
  support::TempDir folder_;
};

TEST_F(InputNumbers, Pbrt) {
  const auto path = in_folder("scene.pbrt");
  walk(read_bytes(kSamples / "everything.pbrt"), TextKind::kPbrt, path, path, 120);
}

TEST_F(InputNumbers, Mitsuba) {
  const auto path = in_folder("scene.xml");
  walk(read_bytes(kSamples / "everything.xml"), TextKind::kXml, path, path, 120);
}

TEST_F(InputNumbers, TextScene) {
  const auto path = in_folder("scene.textproto");
  write_blobs_of_the_sample(path.parent_path());
  walk(read_bytes(kSamples / "everything.textproto"), TextKind::kProto, path, path, 40);
}

TEST_F(InputNumbers, CornellBox) {
  const auto path = in_folder("scene.pbrt");
  walk(read_bytes("scenes/cornell-box/scene.pbrt"), TextKind::kPbrt, path, path, 100);
}

TEST_F(InputNumbers, FirstLight) {
  const auto path = in_folder("scene.textproto");
  walk(read_bytes("scenes/first-light/scene.textproto"), TextKind::kProto, path, path, 100);
}

TEST_F(InputNumbers, AsciiPly) {
  const auto scene = in_folder("scene.pbrt");
  write_bytes(scene,
              "LookAt 0 3 3  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n"
              "Shape \"plymesh\" \"string filename\" \"mesh.ply\"\n");
  walk(ascii_ply(), TextKind::kPlain, in_folder("mesh.ply"), scene, 150);
}

TEST_F(InputNumbers, Obj) {
  const auto scene = in_folder("scene.xml");
  write_bytes(
      scene,
      "<scene version='3.0.0'><sensor type='perspective'><transform name='to_world'><lookat origin='0 3 3' "
      "target='0 0 0' "
      "up='0 1 0'/></transform></sensor><emitter type='constant'/><shape type='obj'><string name='filename' "
      "value='mesh.obj'/></shape></scene>");
  walk(obj_square(), TextKind::kPlain, in_folder("mesh.obj"), scene, 150);
}

/// Mitsuba's own test scenes, a share of each one's numbers.
TEST_F(InputNumbers, MitsubaSuite) {
  const auto suite = test::find_corpus("mitsuba-suite");
  if (!suite) GTEST_SKIP() << test::needs("../shared/scenes/mitsuba-suite.tar.xz");
  if (!test::long_form()) GTEST_SKIP() << "in the long form only";
  std::vector<std::filesystem::path> scenes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(suite->path() / "tests")) {
    // The other files are parts that these include.
    const std::string name = entry.path().filename().string();
    if (name.starts_with("test_") && name.ends_with(".xml")) scenes.push_back(entry.path());
  }
  std::sort(scenes.begin(), scenes.end());
  ASSERT_FALSE(scenes.empty());
  for (const std::filesystem::path& path : scenes) {
    SCOPED_TRACE(path.filename().string());
    walk(read_bytes(path), TextKind::kXml, path, path, 2);
  }
}

}  // namespace
}  // namespace tessera::stress
