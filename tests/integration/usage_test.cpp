// Messages for users who call the programs wrongly, or ask for help; and the documentation against the
// programs' own option lists.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kUsedScene = "scenes/cornell-box/scene.pbrt";

support::Finished run(const Arguments& command) { return support::run_program(command, kPatience); }

std::vector<std::string> lines_of(const std::string& text) { return absl::StrSplit(text, '\n'); }

/// The commands that `tessera --help` lists, or the help of a command that has some within it.
std::vector<std::string> commands(const Arguments& within = {}) {
  std::vector<std::string> names;
  const std::regex command{"^  ([a-z]+)  +.*"};
  for (const std::string& line : lines_of(tessera(within + Arguments{"--help"}).out)) {
    std::smatch match;
    if (std::regex_match(line, match, command)) names.push_back(match[1]);
  }
  return names;
}

/// Every way to ask for help.
std::vector<Arguments> helps() {
  std::vector<Arguments> helps{
      {server_program(), "--help"}, {worker_program(), "--help"}, {tessera_program(), "--help"}};
  for (const std::string& command : commands()) helps.push_back({tessera_program(), command, "--help"});
  for (const std::string& command : commands({"lightfield"}))
    helps.push_back({tessera_program(), "lightfield", command, "--help"});
  return helps;
}

/// Names of options, such as "--spp", in a text.
std::set<std::string> options_in(const std::string& text) {
  static const std::regex option{"--[a-z][a-z-]*|(?:^|[^-A-Za-z0-9])-[oD]\\b"};
  std::set<std::string> found;
  for (auto at = std::sregex_iterator(text.begin(), text.end(), option); at != std::sregex_iterator(); ++at) {
    const std::string name = at->str();
    found.insert(name.substr(name.find('-')));
  }
  return found;
}

/// The options that a --help lists, not those that its texts mention.
std::set<std::string> options_of(const Arguments& help) {
  std::set<std::string> found;
  static const std::regex option{"^ +(?:(-[a-zA-Z]), )? *(--?[a-zA-Z][a-z-]*).*"};
  for (const std::string& line : lines_of(run(help).out)) {
    std::smatch match;
    if (!line.starts_with("  ") || !std::regex_match(line, match, option)) continue;
    if (line.find_first_not_of(' ') > 6) continue;  // a text that goes on
    for (const std::size_t group : {1, 2}) {
      if (match[group].matched) found.insert(match[group]);
    }
  }
  return found;
}

std::string documentation() {
  std::ifstream in{"docs/command-line.md"};
  return {std::istreambuf_iterator<char>{in}, {}};
}

/// From one heading to the next of its rank.
std::string section(const std::string& heading) {
  const std::string text = documentation();
  const std::size_t begin = text.find("\n" + heading + "\n");
  EXPECT_NE(begin, std::string::npos) << heading;
  const std::string rank = "\n" + heading.substr(0, heading.find(' ') + 1);
  return text.substr(begin, text.find(rank, begin + 1) - begin);
}

TEST(Usage, AWrongCommandIsToldInOneLineWithTheNearest) {
  const support::Finished done = tessera({"rendr"});
  EXPECT_EQ(done.status.code, 2);
  EXPECT_EQ(done.err,
            "tessera: there is no command 'rendr'; did you mean 'render'?\n"
            "usage: tessera COMMAND [options]   (more: tessera --help)\n");
}

TEST(Usage, WhatIsWrongIsSaidInPlainWordsByEveryProgram) {
  const std::vector<std::pair<Arguments, std::string>> cases{
      {{tessera_program(), "render", kUsedScene, "-o", "x.exr", "--spp", "4", "--spp", "8"},
       "--spp is given twice"},
      {{tessera_program(), "render", kUsedScene, "-o", "x.exr", "--nosie", "0.1"}, "did you mean '--noise'"},
      {{tessera_program(), "render", kUsedScene, "-o", "x.exr", "--threads", "0"},
       "a whole number from 1 to 1024, not '0'"},
      {{server_program(), "--listn", "127.0.0.1:0"}, "did you mean '--listen'"},
      {{server_program(), "--tls-user", "alice"}, "--tls-user requires --init-tls"},
      {{worker_program(), "--server", "127.0.0.1:1", "--threads", "many"},
       "a whole number from 1 to 1024, not 'many'"},
      {{worker_program(), "now"}, "'now' is one word too many"}};
  for (const auto& [command, text] : cases) {
    const support::Finished done = run(command);
    EXPECT_EQ(done.status.code, 2) << done.err;
    EXPECT_THAT(done.err, HasSubstr(text));
    EXPECT_THAT(done.err, HasSubstr("\nusage: tessera"));
    EXPECT_EQ(lines_of(done.err).size(), 3u) << "what is wrong, and one line of usage:\n" << done.err;
  }
}

TEST(Usage, HelpFitsEightyColumnsWithoutJargon) {
  ASSERT_GT(commands().size(), 15u);
  for (const Arguments& help : helps()) {
    const support::Finished done = run(help);
    EXPECT_EQ(done.status.code, 0);
    for (const std::string& line : lines_of(done.out)) EXPECT_LE(line.size(), 80u) << line;
    EXPECT_THAT(done.out, HasSubstr("usage: tessera"));
    for (const char* jargon : {"UINT", "INT:", "TEXT:", "REQUIRED", "Env:", "Excludes", "Needs"}) {
      EXPECT_THAT(done.out, Not(HasSubstr(jargon))) << help[0] << " " << help[1];
    }
    if (help != Arguments{tessera_program(), "--help"}) {
      EXPECT_THAT(done.out, HasSubstr("\nfor example\n  tessera"));
    }
  }
}

TEST(Usage, HelpOfRenderIsReadAtOnce) {
  EXPECT_LE(lines_of(tessera({"render", "--help"}).out).size(), 61u)
      << "60 lines, and what is after the last";
}

TEST(Usage, AFormerNameIsTakenWithANotice) {
  const support::Finished done =
      tessera({"render", "no-such-scene.pbrt", "-o", "x.exr", "--mutations", "64"});
  EXPECT_THAT(done.err, HasSubstr("note: --mutations is --set mlt.mutations=N from now on"));
  EXPECT_THAT(done.err, HasSubstr("there is no file no-such-scene.pbrt"));
}

TEST(Usage, AnEmptyValueIsNone) {
  EXPECT_THAT(tessera({"render", kUsedScene, "-o", "x.exr", "--seed", ""}).err, HasSubstr("not ''"));
}

TEST(Documentation, HasEveryOptionOfEveryProgram) {
  for (const Arguments& help : helps()) {
    const bool server = help[0] == server_program(), worker = help[0] == worker_program();
    const std::set<std::string> documented = options_in(section(server                 ? "## tessera-server"
                                                                : worker               ? "## tessera-worker"
                                                                : help[1] == "bench"   ? "## bench"
                                                                : help[1] == "query"   ? "## query"
                                                                : help[1] == "lens"    ? "## lens"
                                                                : help[1] == "compare" ? "## compare"
                                                                : help[1] == "lightfield" ? "## lightfield"
                                                                                          : "## tessera"));
    const std::set<std::string> shared = options_in(section("## tessera"));
    const std::set<std::string> options = options_of(help);
    EXPECT_GT(options.size(), 0u) << help[1];
    for (const std::string& option : options) {
      if (option == "--help" || option == "-h" || option == "--version") continue;
      EXPECT_TRUE(documented.contains(option) || (!server && !worker && shared.contains(option)))
          << help[0] << " " << help[1] << " has " << option << ", and docs/command-line.md does not";
    }
  }
}

TEST(Documentation, HasNoOptionThatThereIsNot) {
  std::set<std::string> options{"--help", "--version"};
  for (const Arguments& help : helps()) options.merge(options_of(help));
  static const std::regex setting{"^  ([a-z.-]+)(=| ).*"};
  for (const std::string& line : lines_of(tessera({"settings"}).out)) {
    std::smatch match;
    if (std::regex_match(line, match, setting)) options.insert("--" + match[1].str());
  }
  for (const std::string& option : options_in(documentation())) {
    EXPECT_TRUE(options.contains(option)) << option << " is in docs/command-line.md, and no program has it";
  }
}

TEST(Documentation, HasEveryAov) {
  const support::Finished done = tessera({"render", kUsedScene, "-o", "x.exr", "--aov", "beauty"});
  const std::size_t begin = done.err.find("there is: ") + 10;
  const std::string list = done.err.substr(begin, done.err.find('\n', begin) - begin);
  const std::string documented = section("### Options of `render` and `submit`");
  for (std::string name : std::vector<std::string>(absl::StrSplit(list, ", "))) {
    EXPECT_THAT(documented, HasSubstr("`" + name + "`"));
    EXPECT_THAT(tessera({"settings", "aov"}).out, HasSubstr(name));
  }
}

TEST(Documentation, ListsTheIntegratorsThatHelpLists) {
  const std::string help = tessera({"settings", "integrator"}).out;
  static const std::regex row{"\\| `([a-z-]+)` \\| .* \\| ([a-z]+) \\|"};
  int rows = 0;
  for (const std::string& line : lines_of(section("### Integrators"))) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    ++rows;
    // The kind is the last that is said of it but for what it is blind to, after line breaks in the help's
    // right column.
    const std::regex said{
        absl::StrCat("\n +", match[1].str(), " [^;]*;\\s+", match[2].str(), "(,\\s+blind\\s+to[^;]*)?\n")};
    EXPECT_TRUE(std::regex_search(help, said)) << line << "\n" << help;
  }
  EXPECT_GE(rows, 6);
}

TEST(Usage, ASceneThatIsNotThereIsAUsageError) {
  const support::Finished done = tessera({"render", "no-such-scene.pbrt", "-o", "x.exr"});
  EXPECT_EQ(done.status.code, 2) << "as docs/command-line.md says of a file that does not exist";
  EXPECT_THAT(done.err, HasSubstr("there is no file no-such-scene.pbrt"));
}

TEST(Usage, FilesThatCannotBeWrittenAreNoticedBeforeRendering) {
  const support::TempDir folder;
  const std::string image = (folder.path() / "x.exr").string();
  const support::Finished done =
      tessera({"render", kUsedScene, "-o", image, "--stats", "/no/such/folder/stats.json"});
  EXPECT_EQ(done.status.code, 2);
  EXPECT_THAT(done.err, HasSubstr("there is no folder /no/such/folder"));
  EXPECT_FALSE(std::filesystem::exists(image));
}

TEST(Usage, AnImageIsWrittenWhereALinkLeads) {
  const support::TempDir folder;
  const auto link = folder.path() / "latest.EXR", target = folder.path() / "frame-1.exr";
  std::filesystem::create_symlink("frame-1.exr", link);
  const support::Finished done =
      tessera({"render", kUsedScene, "--resolution", "16x16", "--spp", "1", "-o", link.string(), "--quiet"});
  EXPECT_EQ(done.status.code, 0) << done.err;
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_TRUE(std::filesystem::is_regular_file(target));
}

TEST(Usage, ALocalRenderHasNoNetwork) {
  const support::TempDir folder;
  const support::Finished done = tessera({"render", kUsedScene, "--resolution", "16x16", "--spp", "1", "-o",
                                          (folder.path() / "x.exr").string()});
  EXPECT_EQ(done.status.code, 0) << done.err;
  EXPECT_THAT(done.err, Not(HasSubstr("network")));
  EXPECT_THAT(done.err, ContainsRegex("CPU s: start [0-9]+ %"));
}

TEST(Usage, NobodyAtTheAddressIsToldWithWhatToDo) {
  // Nothing listens on port 1: it is reserved.
  const support::Finished done = tessera({"jobs", "--server", "127.0.0.1:1"});
  EXPECT_EQ(done.status.code, 4);
  EXPECT_EQ(done.err,
            "tessera: no coordinator at 127.0.0.1:1 (is tessera-server running? --server, TESSERA_SERVER)\n");
}

TEST(Usage, ACoordinatorWithoutJoiningRefusesATokenAsDocumented) {
  const FarmUnderTest farm;
  const support::Finished done = tessera(farm.on_farm({"token"}));
  EXPECT_EQ(done.status.code, 4);
  EXPECT_THAT(done.err, HasSubstr("--join-authority"));
}

TEST(Usage, TlsIsAskedForWhereItIsSpokenAndRefusedWhereNot) {
  const support::TempDir folder;
  const std::string tls = (folder.path() / "tls").string();
  const support::Finished made =
      run({server_program(), "--init-tls", tls, "--tls-host", "localhost", "--tls-user", "alice"});
  ASSERT_EQ(made.status.code, 0) << made.err;
  for (const char* text :
       {"authority", "client-alice", "next:\n  tessera-server --listen localhost:7070 --tls ",
        "sudo chown -R tessera: "}) {
    EXPECT_THAT(made.out, HasSubstr(text));
  }
  support::Process server{{server_program(), "--listen", "127.0.0.1:0", "--data",
                           (folder.path() / "data").string(), "--tls", tls + "/server"}};
  const auto address = server.wait_for_line("listening on ", kPatience);
  ASSERT_TRUE(address) << server.err();
  const support::Finished plain = tessera({"jobs", "--server", *address});
  EXPECT_EQ(plain.status.code, 4);
  EXPECT_EQ(plain.err, "tessera: " + *address + " speaks TLS: give --tls DIR (TESSERA_TLS)\n");
  EXPECT_EQ(tessera({"jobs", "--server", *address, "--tls", tls + "/client-alice"}).status.code, 0);

  const FarmUnderTest farm;
  const support::Finished encrypted = tessera(farm.on_farm({"jobs", "--tls", tls + "/client-alice"}));
  EXPECT_EQ(encrypted.status.code, 4);
  EXPECT_THAT(encrypted.err, HasSubstr("does not speak TLS: leave --tls (TESSERA_TLS) away"));
}

TEST(Jobs, AreChangedSeveralAtATimeByTheBeginningsOfTheirIds) {
  FarmUnderTest farm;  // without a worker: jobs wait
  const Arguments scene{kUsedScene, "--resolution", "16x16", "--spp", "1", "--fresh"};
  std::vector<std::string> jobs;
  for (int i = 0; i < 4; ++i) jobs.push_back(farm.submit_detached(scene));
  const auto beginning = [&](const std::string& id) {
    for (std::size_t length = 1; length < id.size(); ++length) {
      const std::string cut = id.substr(0, length);
      if (std::ranges::count_if(jobs, [&](const std::string& job) { return job.starts_with(cut); }) == 1)
        return cut;
    }
    return id;
  };
  const support::Finished paused = tessera(farm.on_farm({"pause", beginning(jobs[0]), beginning(jobs[1])}));
  EXPECT_EQ(paused.status.code, 0) << paused.err;
  EXPECT_EQ(paused.out, "job " + jobs[0] + ": queued, paused\njob " + jobs[1] + ": queued, paused\n");
  EXPECT_EQ(lines_of(tessera(farm.on_farm({"jobs", "--state", "paused"})).out).size(), 4u)
      << "a heading, two, the end";
  EXPECT_EQ(tessera(farm.on_farm({"priority", jobs[2], jobs[3], "-7"})).status.code, 0);
  EXPECT_THAT(tessera(farm.on_farm({"jobs"})).out, HasSubstr("-7"));

  EXPECT_EQ(tessera(farm.on_farm({"cancel", "--state", "paused"})).status.code, 0);
  const support::Finished none = tessera(farm.on_farm({"cancel"}));
  EXPECT_EQ(none.status.code, 2);
  EXPECT_THAT(none.err, HasSubstr("which jobs?"));
  EXPECT_EQ(tessera(farm.on_farm({"cancel", "zzz"})).status.code, 2);
  const support::Finished open = tessera(farm.on_farm({"delete", jobs[2]}));
  EXPECT_EQ(open.status.code, 4);
  EXPECT_THAT(open.err, HasSubstr("is not over: cancel it first"));
  const support::Finished deleted = tessera(farm.on_farm({"delete", "--all"}));
  EXPECT_EQ(lines_of(deleted.out).size(), 3u) << "the two that are over, and the end:\n" << deleted.out;
  EXPECT_EQ(lines_of(tessera(farm.on_farm({"cancel", "--all"})).out).size(), 3u);
  EXPECT_EQ(tessera(farm.on_farm({"delete", "--all"})).status.code, 0);
  EXPECT_EQ(tessera(farm.on_farm({"jobs"})).out, "there are no jobs\n");
}

TEST(Jobs, AWatcherIsToldWhatItWaitsForAndOfAPause) {
  FarmUnderTest farm;
  const std::string job = farm.submit_detached({kUsedScene, "--resolution", "16x16", "--spp", "1"});
  support::Process watch{Arguments{tessera_program()} + farm.on_farm({"watch", job})};
  EXPECT_TRUE(watch.wait_for_err("waiting: ", kPatience)) << watch.err();
  ASSERT_EQ(tessera(farm.on_farm({"pause", job})).status.code, 0);
  EXPECT_TRUE(watch.wait_for_err("job " + job + " is paused", kPatience)) << watch.err();
  ASSERT_EQ(tessera(farm.on_farm({"resume", job})).status.code, 0);
  EXPECT_TRUE(watch.wait_for_err("job " + job + " goes on", kPatience)) << watch.err();
  farm.add_worker(1);
  const auto ended = watch.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 0) << watch.err();
}

TEST(Jobs, WithNoiseTheSamplesThatWereTakenAreTold) {
  const support::TempDir folder;
  const auto stats = folder.path() / "stats.json";
  const support::Finished done =
      tessera({"render", kUsedScene, "--resolution", "64x64", "--noise", "0.5", "--spp", "4096", "--stats",
               stats.string(), "-o", (folder.path() / "x.exr").string()});
  ASSERT_EQ(done.status.code, 0) << done.err;
  const double taken = json_number(stats, "samples");
  ASSERT_LT(taken, 64 * 64 * 4096 / 4.0) << "the noise has ended it";
  // Three digits are shown: 0.5 % at most are rounded off.
  const std::regex told{"100% \\(([0-9.]+)([kM]?) samples\\)"};
  std::smatch match;
  ASSERT_TRUE(std::regex_search(done.err, match, told)) << done.err;
  const double unit = match[2] == "k" ? 1e3 : match[2] == "M" ? 1e6 : 1;
  EXPECT_NEAR(std::stod(match[1]) * unit, taken, 0.005 * taken);
}

TEST(Usage, AProgramWithoutItsModulesNamesThemAndWhereItLooked) {
  const support::TempDir folder;
  std::filesystem::create_directory(folder.path() / "bin");
  for (const std::string& program : {worker_program(), tessera_program()}) {
    std::filesystem::copy(program, folder.path() / "bin");
  }
  const std::string bin = (folder.path() / "bin/").string();
  const support::Finished worker = run({bin + "tessera-worker", "--server", "127.0.0.1:1"});
  EXPECT_EQ(worker.status.code, 2);
  const support::Finished local = run({bin + "tessera", "render", kUsedScene, "-o", bin + "x.exr"});
  EXPECT_EQ(local.status.code, 5);
  for (const std::string& err : {worker.err, local.err}) {
    EXPECT_THAT(err, HasSubstr("libtessera_kernel_"));
    EXPECT_THAT(err, HasSubstr("Looked in " + bin + "../lib"));
  }
}

TEST(Usage, AWorkerRefusesModulesOfAnotherBuildByName) {
  const support::TempDir folder;
  for (const char* const name : {"bin", "lib"}) std::filesystem::create_directory(folder.path() / name);
  std::filesystem::copy(worker_program(), folder.path() / "bin");
  const std::filesystem::path programs = std::filesystem::path(worker_program()).parent_path().parent_path();
  for (const char* const isa : {"avx512", "avx2", "neon"}) {
    std::filesystem::copy(programs / "lib/libother_kernel_module.so",
                          folder.path() / absl::StrCat("lib/libtessera_kernel_", isa, ".so"));
  }
  const support::Finished worker =
      run({(folder.path() / "bin/tessera-worker").string(), "--server", "127.0.0.1:1"});
  EXPECT_EQ(worker.status.code, 2);
  EXPECT_THAT(worker.err,
              ContainsRegex("libtessera_kernel_[a-z0-9]+.so belongs to build 0.0.9-abc, this program"));
}

TEST(Completion, OfBashFindsCommandsOptionsAndWords) {
  const std::string script = ::testing::TempDir() + "tessera-completion.bash";
  std::ofstream(script) << tessera({"--completion", "bash"}).out << R"(
complete_words() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _tessera; echo "${COMPREPLY[*]}"; }
complete_words tessera den
complete_words tessera render --den
complete_words tessera render --denoise re
complete_words tessera render --sampler = z
)";
  const support::Finished done = run({"/bin/bash", script});
  std::filesystem::remove(script);
  EXPECT_EQ(done.out, "denoise\n--denoise\nregression\nz-sobol\n") << done.err;
}

TEST(Usage, AnIntegratorThatThereIsNotHasItsNearestName) {
  const std::string err = tessera({"render", kUsedScene, "-o", "x.exr", "--integrator", "pth"}).err;
  EXPECT_THAT(err, HasSubstr("there is no integrator 'pth'; did you mean 'path'?; there is: path, "));
  EXPECT_THAT(err, HasSubstr(", auto"));
  EXPECT_THAT(tessera({"render", kUsedScene, "-o", "x.exr", "--integrator", "atuo"}).err,
              HasSubstr("did you mean 'auto'?"));
  EXPECT_THAT(tessera({"render", kUsedScene, "-o", "x.exr", "--integrator", "preview"}).err,
              HasSubstr("there is no integrator 'preview' any more; 'raycast' shows"));
}

TEST(Usage, HelpNamesEveryKindOfSceneFile) {
  for (const char* const command : {"render", "submit", "query", "radiosity"}) {
    EXPECT_THAT(tessera({command, "--help"}).out, ContainsRegex("\\.obj,\\s+\\.stl,\\s+\\.fbx,\\s+\\.dae"))
        << command;
  }
}

TEST(Frames, OfACommandThatIsGivenAgainAreTheJobsOfThen) {
  FarmUnderTest farm;
  const auto submit = [&](const Arguments& more) {
    const Arguments command{"submit", kUsedScene, "--resolution", "8x8",     "--spp",
                            "1",      "--frames", "1-3",          "--detach"};
    const support::Finished done = tessera(farm.on_farm(command + more));
    EXPECT_EQ(done.status.code, 0) << done.err;
    EXPECT_THAT(done.err, HasSubstr("3 frames submitted"));
    return lines_of(done.out);
  };
  const std::vector<std::string> first = submit({});
  ASSERT_EQ(first.size(), 4u) << "a line each, and an end";
  EXPECT_EQ(submit({}), first);
  const std::vector<std::string> fresh = submit({"--fresh"});
  const std::vector<std::string> other = submit({"--priority", "3"});
  for (const std::size_t frame : {0, 1, 2}) {
    EXPECT_NE(fresh[frame], first[frame]);
    EXPECT_NE(other[frame], first[frame]);
  }
  // One that was given up is begun anew, once.
  const std::string second_id = first[1].substr(std::string("job ").size());
  EXPECT_EQ(tessera(farm.on_farm({"cancel", second_id})).status.code, 0);
  const std::vector<std::string> again = submit({});
  EXPECT_EQ(again[0], first[0]);
  EXPECT_NE(again[1], first[1]);
  EXPECT_EQ(again[2], first[2]);
  EXPECT_EQ(submit({}), again);
  farm.add_worker(1);
  const std::string id = first[0].substr(std::string("job ").size());
  EXPECT_EQ(farm.watch_to_the_end(id).state(), v1::DONE);
  EXPECT_EQ(submit({}), again) << "and where they are done";
}

TEST(Usage, TheUserIsKnownWithoutALogin) {
  FarmUnderTest farm;
  const support::Finished done =
      run(Arguments{"/usr/bin/env", "-u", "USER", tessera_program()} +
          farm.on_farm({"submit", kUsedScene, "--resolution", "8x8", "--spp", "1", "--detach"}));
  ASSERT_EQ(done.status.code, 0) << done.err;
  const std::string name = lines_of(run({"/usr/bin/id", "-un"}).out).front();
  const auto jobs = farm.client().jobs({});
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  EXPECT_EQ(jobs->front().user(), name);
}

TEST(Desk, WritesASceneAndAConfigurationThatHold) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "tessera-desk";
  std::filesystem::remove_all(folder);
  const std::string config = folder / "config.toml", scene = folder / "scene.textproto";
  const auto with_config = [&](const Arguments& arguments) {
    return run(Arguments{"/usr/bin/env", "TESSERA_CONFIG=" + config, "TESSERA_SERVER=", tessera_program()} +
               arguments);
  };
  EXPECT_EQ(with_config({"init", folder}).status.code, 0);
  // It has comments alone, but it is there.
  EXPECT_THAT(with_config({"doctor"}).out, HasSubstr("ok\tconfiguration: " + config + ", 0 settings\n"));
  for (const char* const value : {"8", "4"}) {
    const auto set = with_config({"config", "set", "render.spp", value});
    EXPECT_EQ(set.status.code, 0) << set.err;
  }
  EXPECT_EQ(with_config({"config", "get", "render.spp"}).out, "4\n");
  const std::string picture = folder / "picture.exr", other = folder / "other.exr";
  const Arguments render{"render", scene, "--resolution", "16x16", "--quiet"};
  EXPECT_EQ(with_config(render + Arguments{"-o", picture}).status.code, 0);
  EXPECT_EQ(run(Arguments{tessera_program()} + render + Arguments{"--spp", "4", "-o", other}).status.code, 0);
  EXPECT_THAT(tessera({"compare", other, picture}).out, HasSubstr("MSE    0 "));
  // The port 1 of this machine: nobody listens there.
  EXPECT_EQ(with_config({"config", "set", "server", "127.0.0.1:1"}).status.code, 0);
  const auto doctor = with_config({"doctor"});
  EXPECT_EQ(doctor.status.code, 9);
  EXPECT_THAT(doctor.out, HasSubstr("fault\tcoordinator: nobody listens at 127.0.0.1:1"));
  std::ofstream(config) << "[render]\nspp = none\n";
  const auto refused = with_config(render + Arguments{"-o", picture});
  EXPECT_EQ(refused.status.code, 2);
  EXPECT_THAT(refused.err, HasSubstr(config + ":2"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace tessera::integration
