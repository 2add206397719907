// Who may include whom: the plan of the house (docs/architecture.md), held against every #include of the
// sources.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

using Rooms = std::set<std::string>;

/// A folder, and the rooms that its files may include from (besides the standard library and packages).
const std::map<std::string, Rooms>& rules() {
  static const std::map<std::string, Rooms> rules = {
      {"proto/tables", {"tables"}},
      {"proto/base", {"base"}},
      {"proto/images", {"images"}},
      {"proto/layers", {"layers"}},
      {"proto/expression", {"expression"}},
      {"proto/wire", {"wire", "base", "layers", "tessera/v1"}},
      {"proto/telemetry", {"telemetry", "base"}},
      {"proto/transport", {"transport", "base", "telemetry", "wire", "tessera/v1"}},
      {"proto/options", {"options", "base"}},
      {"server/scheduler", {"scheduler", "base", "wire", "tessera/v1"}},
      {"server/store", {"store", "telemetry", "wire", "tessera/v1"}},
      {"server/tls", {"tls", "base", "transport", "wire"}},
      {"server/net", {"net", "base", "telemetry"}},
      {"server/service",
       {"service", "net", "scheduler", "store", "tls", "base", "telemetry", "transport", "wire",
        "tessera/v1"}},
      {"server/notify", {"notify", "service", "telemetry", "wire", "tessera/v1"}},
      {"worker/agent",
       {"agent", "render", "render/build", "base", "options", "telemetry", "transport", "wire",
        "tessera/v1"}},
      {"client/farm", {"farm", "import", "base", "transport", "wire", "tessera/v1"}},
      {"client/image", {"image", "base", "wire"}},
      {"client/import", {"import", "base", "expression", "images", "tables", "wire", "tessera/v1"}},
      {"client/display", {"display", "base", "image", "wire"}},
      {"client/mesh", {"mesh"}},
      {"client/plot", {"plot", "image"}},
      {"client/denoise", {"denoise", "image", "import", "render/core", "wire"}},
      {"client/bench",
       {"bench", "base", "denoise", "image", "import", "local", "plot", "wire", "tessera/v1"}},
      {"client/pilot", {"pilot", "bench", "image"}},
      {"client/command",
       {"command", "base", "bench", "denoise", "display", "expression", "farm", "image", "import", "layers",
        "local", "mesh", "options", "pilot", "plot", "transport", "wire", "tessera/v1"}},
      {"client/local",
       {"local", "base", "farm", "import", "mesh", "agent", "render/build", "service", "store", "transport",
        "wire", "tessera/v1"}},
      {"worker/render/core", {"render/core"}},
      {"worker/render/sampling", {"render/sampling", "render/core"}},
      {"worker/render/color", {"render/color", "render/core", "images", "tables"}},
      {"worker/render/shape", {"render/shape", "render/core", "expression", "tables"}},
      {"worker/render/camera", {"render/camera", "render/core", "render/sampling"}},
      {"worker/render/accel",
       {"render/accel", "render/shape", "render/core", "render/color", "render/sampling"}},  // colour: alpha
      {"worker/render/query", {"render/query", "render/accel", "render/shape", "render/core"}},
      {"worker/render/bsdf", {"render/bsdf", "render/color", "render/core", "render/sampling"}},
      {"worker/render/medium", {"render/medium", "render/color", "render/core", "render/sampling"}},
      {"worker/render/film", {"render/film", "render/core", "base", "wire"}},
      {"worker/render/light",
       {"render/light", "render/shape", "render/color", "render/core", "render/sampling"}},
      {"worker/render/integrator",
       {"render", "render/integrator", "render/accel", "render/bsdf", "render/camera", "render/color",
        "render/core", "render/film", "render/light", "render/medium", "render/query", "render/sampling",
        "render/shape", "base", "layers", "wire"}},
      {"worker/render/build",
       {"render", "render/build", "render/accel", "render/bsdf", "render/camera", "render/color",
        "render/core", "render/film", "render/integrator", "render/light", "render/medium", "render/query",
        "render/sampling", "render/shape", "base", "expression", "layers", "wire", "tessera/v1"}},
  };
  return rules;
}

/// The room of an include: "render/core/wide.h" is in render/core, "render/renderer.h" in render,
/// "image/exr.h" in image.
std::string room_of(const std::string& include) {
  static const Rooms tops = {"wire",       "base",   "images",  "telemetry", "transport", "scheduler",
                             "store",      "tls",    "net",     "service",   "agent",     "farm",
                             "image",      "import", "command", "local",     "render",    "tessera",
                             "plot",       "bench",  "options", "tables",    "layers",    "mesh",
                             "expression", "notify", "denoise"};
  const auto first = include.find('/');
  const std::string top = include.substr(0, first);
  if (first == std::string::npos || !tops.contains(top)) return "";  // a package
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
  for (const char* top : {"proto", "server", "worker", "client"}) {
    for_each_source(top, [](const fs::path& file) {
      const std::string folder = file.parent_path().string();
      bool covered = file.filename() == "main.cpp" || file.filename() == "renderer.h";
      for (const auto& [prefix, rooms] : rules()) covered = covered || folder.rfind(prefix, 0) == 0;
      EXPECT_TRUE(covered) << file << ": no rule says what its folder may include";
    });
  }
}

TEST(IncludeRules, TheRendererKnowsNeitherGrpcNorProtobufOutsideBuild) {
  for_each_source("worker/render", [](const fs::path& file) {
    const bool build = file.string().find("render/build/") != std::string::npos;
    for (const std::string& include : includes_of(file)) {
      EXPECT_NE(include.rfind("grpc", 0), 0u) << file << " includes " << include;
      EXPECT_TRUE(build || include.find(".pb.h") == std::string::npos) << file << " includes " << include;
    }
  });
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

/// Time is injected (server/service/farm/farm_clock.h), and threads are waited for by what they do.
TEST(UnitTests, DoNotSleep) {
  // A handshake that takes its time: gRPC's own clock runs there.
  static const std::map<std::string, int> allowed = {{"tests/unit/server/access/tls_test.cpp", 1}};
  static const std::regex sleep("\\b(sleep_for|sleep_until|usleep|nanosleep) *\\(");
  std::size_t seen = 0;
  for_each_source("tests/unit", [&](const fs::path& file) {
    ++seen;
    int sleeps = 0;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) sleeps += std::regex_search(line, sleep);
    const auto found = allowed.find(file.string());
    EXPECT_EQ(sleeps, found == allowed.end() ? 0 : found->second) << file;
  });
  EXPECT_GT(seen, 100u);
}

}  // namespace
