// Who may include whom: the plan of the house (docs/architecture.md), held against every #include of the
// sources.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;

using Rooms = std::set<std::string>;

/// A folder, and the rooms that its files may include from (besides the standard library and packages).
const std::map<std::string, Rooms>& rules() {
  static const std::map<std::string, Rooms> rules = {
      {"proto/wire", {"wire", "base", "layers", "optics", "photometry", "spectra", "tessera/v1"}},
      {"lib/tables", {"tables"}},
      {"lib/spectra", {"spectra", "base"}},
      {"lib/optics", {"optics", "base", "spectra"}},
      {"lib/photometry", {"photometry", "base", "spectra"}},
      {"lib/base", {"base"}},
      {"lib/images", {"images", "base"}},
      {"lib/layers", {"layers"}},
      {"lib/light_field", {"light_field", "images", "wire"}},
      {"lib/expression", {"expression"}},
      {"lib/telemetry", {"telemetry", "base"}},
      {"lib/net", {"net", "base", "telemetry", "wire", "tessera/v1"}},
      {"lib/options", {"options", "base"}},
      {"server/scheduler", {"scheduler", "base", "wire", "tessera/v1"}},
      {"server/store", {"store", "base", "telemetry", "wire", "tessera/v1"}},
      {"server/tls", {"tls", "base", "net", "wire"}},
      {"server/connections", {"connections", "base", "telemetry"}},
      {"server/service",
       {"service", "connections", "scheduler", "store", "tls", "base", "net", "spectra", "telemetry", "wire",
        "tessera/v1"}},
      {"server/notify", {"notify", "service", "telemetry", "wire", "tessera/v1"}},
      {"worker/agent",
       {"agent", "render", "render/scene", "base", "net", "options", "telemetry", "wire", "tessera/v1"}},
      {"client/farm", {"farm", "import", "base", "net", "wire", "tessera/v1"}},
      {"client/image", {"image", "base", "spectra", "wire"}},
      {"client/import",
       {"import", "base", "expression", "images", "optics", "photometry", "spectra", "tables", "wire",
        "tessera/v1"}},
      {"client/capture", {"capture", "image", "light_field", "wire", "tessera/v1"}},
      {"client/display", {"display", "base", "image", "wire"}},
      {"client/mesh", {"mesh"}},
      {"client/plot", {"plot", "base", "image", "spectra"}},
      {"client/denoise", {"denoise", "image", "import", "render/core", "wire"}},
      {"client/bench",
       {"bench", "base", "denoise", "image", "import", "local", "plot", "wire", "tessera/v1"}},
      {"client/pilot", {"pilot", "bench", "image", "wire"}},
      {"client/measure", {"measure", "base", "image", "import", "photometry", "plot", "wire", "tessera/v1"}},
      {"client/command",
       {"command", "base",   "bench",       "capture", "denoise", "display", "expression", "farm",
        "image",   "import", "layers",      "local",   "measure", "mesh",    "net",        "optics",
        "options", "pilot",  "light_field", "plot",    "spectra", "wire",    "photometry", "tessera/v1"}},
      {"client/local",
       {"local", "base", "farm", "import", "mesh", "net", "agent", "render/scene", "service", "store", "wire",
        "tessera/v1"}},
      {"worker/render/core", {"render/core"}},
      {"worker/render/sampling", {"render/sampling", "render/core"}},
      {"worker/render/color", {"render/color", "render/core", "images", "tables"}},
      {"worker/render/shape", {"render/shape", "render/core", "expression", "tables"}},
      {"worker/render/sensor",
       {"render/sensor", "render/color", "render/core", "render/film", "render/sampling"}},
      {"worker/render/accel",
       {"render/accel", "render/shape", "render/core", "render/color", "render/sampling"}},  // colour: alpha
      {"worker/render/query", {"render/query", "render/accel", "render/shape", "render/core"}},
      {"worker/render/bsdf", {"render/bsdf", "render/color", "render/core", "render/sampling", "spectra"}},
      {"worker/render/medium", {"render/medium", "render/color", "render/core", "render/sampling"}},
      {"worker/render/film", {"render/film", "render/core", "base", "wire"}},
      {"worker/render/light",
       {"render/light", "render/shape", "render/color", "render/core", "render/sampling"}},
      {"worker/render/integrator",
       {"render/integrator", "render/accel", "render/bsdf", "render/color", "render/core", "render/film",
        "render/light", "render/medium", "render/sampling", "render/sensor", "render/shape", "layers",
        "wire"}},
      {"worker/render/transport",
       {"render/transport", "render/integrator", "render/accel", "render/bsdf", "render/color", "render/core",
        "render/film", "render/light", "render/medium", "render/sampling", "render/sensor", "render/shape",
        "base", "layers", "wire"}},
      {"worker/render/textbook",
       {"render/textbook", "render/transport", "render/integrator", "render/accel", "render/color",
        "render/core", "render/film", "render/light", "render/sampling", "render/sensor", "render/shape",
        "base", "wire"}},
      {"worker/render/kernel",
       {"render", "render/kernel", "render/transport", "render/textbook", "render/integrator", "render/accel",
        "render/core", "render/light", "render/query", "wire"}},
      {"worker/render/scene", {"render",          "render/scene",  "render/kernel", "render/integrator",
                               "render/textbook", "render/accel",  "render/bsdf",   "render/color",
                               "render/core",     "render/film",   "render/light",  "render/medium",
                               "render/query",    "render/sensor", "render/shape",  "base",
                               "expression",      "layers",        "images",        "optics",
                               "photometry",      "spectra",       "wire",          "tessera/v1"}},
  };
  return rules;
}

constexpr const char* kRoots[] = {"proto", "lib", "server", "worker", "client"};

/// Folders right below the roots: an include of one of our files begins with such a name.
const Rooms& top_folders() {
  static const Rooms tops = [] {
    Rooms found;
    for (const char* root : kRoots) {
      for (const auto& entry : fs::directory_iterator(root)) {
        if (entry.is_directory()) found.insert(entry.path().filename().string());
      }
    }
    return found;
  }();
  return tops;
}

/// The room of an include: "render/core/wide.h" is in render/core, "render/renderer.h" in render,
/// "image/exr.h" in image.
std::string room_of(const std::string& include) {
  const auto first = include.find('/');
  const std::string top = include.substr(0, first);
  if (first == std::string::npos || !top_folders().contains(top)) return "";  // a package
  const auto second = include.find('/', first + 1);
  const bool deep = top == "render" || top == "tessera";
  return deep && second != std::string::npos ? include.substr(0, second) : top;
}

std::vector<std::string> includes_of(const fs::path& file) {
  static const std::regex pattern("^\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"]");
  std::vector<std::string> result;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::smatch match;
    if (std::regex_search(line, match, pattern)) result.push_back(match[1]);
  }
  return result;
}

template <class F>
void for_each_source(const fs::path& folder, F&& f) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (extension == ".h" || extension == ".cpp") f(entry.path());
  }
}

TEST(IncludeRules, EveryFolderKeepsToItsNeighbours) {
  std::size_t seen = 0;
  for (const auto& [folder, allowed] : rules()) {
    ASSERT_TRUE(fs::is_directory(folder)) << folder << ": the rules name a folder that is not there";
    for_each_source(folder, [&, &permitted = allowed, &where = folder](const fs::path& file) {
      for (const std::string& include : includes_of(file)) {
        const std::string room = room_of(include);
        ++seen;
        EXPECT_TRUE(room.empty() || permitted.contains(room))
            << file << " includes " << include << ", but " << where << " may not look into " << room;
      }
    });
  }
  EXPECT_GT(seen, 500u);  // the test reads what it believes it reads
}

TEST(IncludeRules, EveryFolderOfSourcesHasARule) {
  for (const char* root : kRoots) {
    for_each_source(root, [](const fs::path& file) {
      const std::string folder = file.parent_path().string();
      bool covered = file.filename() == "main.cpp" || file.filename() == "renderer.h";
      for (const auto& [prefix, rooms] : rules()) covered = covered || folder.rfind(prefix, 0) == 0;
      EXPECT_TRUE(covered) << file << ": no rule says what its folder may include";
    });
  }
}

/// Paths of a file and of one that it includes.
using Inclusion = std::pair<std::string, std::string>;

std::vector<Inclusion> all_inclusions() {
  std::vector<Inclusion> found;
  for (const char* from : kRoots) {
    for_each_source(from, [&](const fs::path& file) {
      for (const std::string& include : includes_of(file)) {
        for (const char* root : kRoots) {
          const fs::path included = fs::path(root) / include;
          if (fs::is_regular_file(included)) found.emplace_back(file.string(), included.string());
        }
      }
    });
  }
  return found;
}

bool is_header(const std::string& path) { return path.ends_with(".h"); }

/// Circles among the parts of a folder, as "folder: part part": subfolders that reach each other by what is
/// included below them, and a header and a subfolder whose headers include each other. A source of a folder
/// may include what is below: it puts the parts together.
class Circles {
 public:
  explicit Circles(const std::vector<Inclusion>& inclusions) {
    for (const Inclusion& inclusion : inclusions) add(inclusion);
    for (const auto& [folder, parts] : reached_) {
      for (const auto& [part, others] : parts) {
        std::string circle = folder + ":";
        const Rooms reached = reach(parts, part);
        if (!reached.contains(part)) continue;
        for (const std::string& other : reached) {
          if (reach(parts, other).contains(part)) circle += " " + other;
        }
        found_.insert(circle);
      }
    }
  }

  const Rooms& found() const { return found_; }

 private:
  using Parts = std::map<std::string, Rooms>;

  void add(const Inclusion& inclusion) {
    const fs::path from = inclusion.first, to = inclusion.second;
    auto a = from.begin(), b = to.begin();
    fs::path folder;
    for (; *a == *b && std::next(a) != from.end() && std::next(b) != to.end(); ++a, ++b) folder /= *a;
    const bool from_folder = std::next(a) != from.end(), to_folder = std::next(b) != to.end();
    if (from_folder && to_folder) reached_[folder.string()][a->string()].insert(b->string());
    if (from_folder == to_folder || !is_header(inclusion.first)) return;
    const std::string head = from_folder ? b->string() : a->string(),
                      part = from_folder ? a->string() : b->string();
    Pair& pair = pairs_[folder.string() + ": " + head + " " + part];
    (from_folder ? pair.up : pair.down) = true;
    if (pair.up && pair.down) found_.insert(folder.string() + ": " + head + " " + part);
  }

  /// All parts that `part` includes, directly or by way of others.
  static Rooms reach(const Parts& parts, const std::string& part) {
    Rooms reached;
    std::vector<std::string> left = {part};
    while (!left.empty()) {
      const auto here = parts.find(left.back());
      left.pop_back();
      if (here == parts.end()) continue;
      for (const std::string& next : here->second) {
        if (reached.insert(next).second) left.push_back(next);
      }
    }
    return reached;
  }

  struct Pair {
    bool up = false, down = false;
  };
  std::map<std::string, Parts> reached_;
  std::map<std::string, Pair> pairs_;
  Rooms found_;
};

TEST(IncludeRules, CirclesAreFound) {
  EXPECT_EQ(Circles({{"w/a/x.cpp", "w/b/y.h"}, {"w/b/deep/y.h", "w/c/z.h"}, {"w/c/z.h", "w/d/v.h"}}).found(),
            Rooms{});
  EXPECT_EQ(Circles({{"w/a/x.cpp", "w/b/y.h"}, {"w/b/deep/y.h", "w/c/z.h"}, {"w/c/z.h", "w/a/v.h"}}).found(),
            Rooms{"w: a b c"});
  EXPECT_EQ(Circles({{"w/head.h", "w/a/x.h"}, {"w/a/y.h", "w/head.h"}}).found(), Rooms{"w: head.h a"});
  EXPECT_EQ(Circles({{"w/head.cpp", "w/a/x.h"}, {"w/a/y.h", "w/head.h"}}).found(), Rooms{});
}

TEST(IncludeRules, FoldersFormNoCircles) {
  constexpr const char* kValues = "the folder's own plain values are read by the head";
  static const std::map<std::string, const char*> known = {
      {": lib proto", "the contract's code uses base and layers, and net speaks the contract"},
      {"client/command: jobs report", "tables show what jobs are like; to be parted"},
      {"client/command: render_options.h frames", kValues},
      {"client/import/gltf: context.h file", kValues},
      {"client/import/mitsuba: context.h document", kValues},
      {"server/store: log sqlite", "the logs go into the database, and recovery reads both"},
      {"worker/render/accel: brute bsp bvh grid kd octree sphere_tree structure wide",
       "structure/ has the primitives of all structures, and chooses between them"},
      {"worker/render/accel: ray_structure.h structure", kValues},
      {"worker/render/light: light_table.h selection", kValues},
      {"worker/render/shape: csg implicit", "implicit functions are operands, and give their spans"},
  };
  const std::vector<Inclusion> inclusions = all_inclusions();
  EXPECT_GT(inclusions.size(), 2000u);
  const Circles circles(inclusions);
  for (const std::string& circle : circles.found())
    EXPECT_TRUE(known.contains(circle)) << "a new circle: " << circle;
  for (const auto& [circle, reason] : known)
    EXPECT_TRUE(circles.found().contains(circle)) << "is gone, and to be left out here: " << circle;
}

TEST(IncludeRules, TheRendererKnowsProtobufOnlyInScene) {
  for_each_source("worker/render", [](const fs::path& file) {
    const bool scene = file.string().find("render/scene/") != std::string::npos;
    for (const std::string& include : includes_of(file)) {
      EXPECT_NE(include.rfind("grpc", 0), 0u) << file << " includes " << include;
      EXPECT_TRUE(scene || include.find(".pb.h") == std::string::npos) << file << " includes " << include;
    }
  });
}

/// Layers, guides, caches and the like observe paths (vertex/path_observer.h).
TEST(IncludeRules, ScatteringKnowsNoObserver) {
  static const std::regex observers("layer|straight|glass|guide|recorder|reuse|cache|irradiance",
                                    std::regex::icase);
  for (const char* const name : {"transport/path/shade.cpp", "textbook/whitted/whitted.cpp"}) {
    std::ifstream file(fs::path("worker/render") / name);
    int number = 0;
    for (std::string line; std::getline(file, line);) {
      ++number;
      EXPECT_FALSE(std::regex_search(line, observers)) << name << ':' << number << ": " << line;
    }
    EXPECT_GT(number, 50) << name;
  }
}

TEST(IncludeRules, TheSchedulerHasNoClockThreadsOrSockets) {
  static const Rooms forbidden = {"thread", "mutex",        "condition_variable",
                                  "atomic", "sys/socket.h", "fstream"};
  for_each_source("server/scheduler", [](const fs::path& file) {
    for (const std::string& include : includes_of(file)) {
      EXPECT_FALSE(forbidden.contains(include) || include.rfind("grpc", 0) == 0)
          << file << " includes " << include;
    }
  });
}

/// A line of a test that looks at a clock, or waits for one.
struct ClockUse {
  int lines;
  const char* reason;
};

/// The verdict of a test of the gate depends on the sources alone: time is injected
/// (lib/base/clock.h), threads and processes are waited for by what they do. Whatever needs a
/// clock is in tests/soak.
TEST(Gate, LooksAtNoClock) {
  constexpr const char* kDates = "certificates have dates";
  constexpr const char* kBoundsAHang = "a deadline that only bounds a hang";
  static const std::map<std::string, ClockUse> allowed = {
      {"tests/integration/phases/latched.cpp", {1, "waits between two looks for a file"}},
      {"tests/stress/input/input_judge.cpp", {3, kBoundsAHang}},
      {"tests/support/picture/phases.cpp", {2, "CPU time, printed by tests/bench"}},
      {"tests/support/process/tcp_proxy.cpp", {1, "waits between two looks for the end of a silence"}},
      {"tests/unit/house/include_rules_test.cpp", {2, "this rule"}},
      {"tests/unit/lib/layers/layers_check_test.cpp", {2, kBoundsAHang}},
      {"tests/unit/lib/log_test.cpp", {1, "the type of a time that the test makes up"}},
      {"tests/unit/server/access/expel_test.cpp", {2, kDates}},
      {"tests/unit/server/access/join_test.cpp", {4, kBoundsAHang}},
      {"tests/unit/server/access/listener_test.cpp", {1, kBoundsAHang}},
      {"tests/unit/server/access/tls_fixture.h", {1, kBoundsAHang}},
      {"tests/unit/server/access/tls_test.cpp", {4, "dates; a handshake that takes its time; bounds a hang"}},
      {"tests/unit/server/access/trust_test.cpp", {1, kDates}},
      {"tests/unit/server/web/web_site_test.cpp", {2, "a type; and dates of certificates"}},
  };
  static const std::regex clock(
      "\\b(sleep_for|sleep_until|usleep|nanosleep|steady_clock|system_clock|high_resolution_clock|clock_"
      "gettime|"
      "gettimeofday|thread_cpu_time|std::clock)\\b");
  std::size_t seen = 0;
  for_each_source("tests", [&](const fs::path& file) {
    const std::string name = file.string();
    if (name.starts_with("tests/soak/") || name.starts_with("tests/bench/")) return;
    ++seen;
    int lines = 0;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) lines += std::regex_search(line, clock);
    const auto found = allowed.find(name);
    EXPECT_EQ(lines, found == allowed.end() ? 0 : found->second.lines)
        << name << (found == allowed.end() ? "" : std::string(": ") + found->second.reason);
  });
  EXPECT_GT(seen, 400u);
}

}  // namespace
