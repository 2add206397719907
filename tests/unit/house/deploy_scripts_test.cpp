// Output of the scripts of deploy/ while they build: one line a phase with its time, and all of what went
// wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "support/process/process.h"
#include "support/process/temp_dir.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

/// A source tree that is configured, with a `ninja` of the test's.
class DeployScripts : public testing::Test {
 protected:
  void set_up(const std::string& ninja) {
    fs::create_directories(folder_.path() / "build" / "release");
    std::ofstream{folder_.path() / "build" / "release" / "build.ninja"};
    std::ofstream{folder_.path() / "ninja"} << "#!/bin/sh\n" << ninja;
    fs::permissions(folder_.path() / "ninja", fs::perms::owner_all);
  }
  support::Finished build() const {
    const std::string folder = folder_.path().string();
    const std::string script =
        ". deploy/lib.sh; top=" + folder + "; PATH=" + folder + ":$PATH; build release tessera";
    return support::run_program({"/bin/bash", "-c", script}, std::chrono::seconds{60});
  }
  support::TempDir folder_;
};

TEST_F(DeployScripts, ABuildIsOneLineWithItsTime) {
  set_up("for i in 1 2 3; do echo \"[$i/3] Building CXX object $i.o\"; done\n");
  const support::Finished done = build();
  EXPECT_EQ(done.status.code, 0) << done.err;
  EXPECT_THAT(done.out, MatchesRegex("== building build/release: tessera ... [0-9]+:[0-9][0-9]\n"));
  EXPECT_EQ(done.err, "");
}

TEST_F(DeployScripts, ABuildThatFailsShowsWhatFailed) {
  set_up("echo '[1/2] Building CXX object a.o'; echo 'FAILED: b.o'; echo 'b.cpp:1:1: error: no'; exit 1\n");
  const support::Finished done = build();
  EXPECT_EQ(done.status.code, 1);
  EXPECT_THAT(done.err, HasSubstr("FAILED: b.o\nb.cpp:1:1: error: no\n"));
  EXPECT_THAT(done.err, Not(HasSubstr("a.o")));
  EXPECT_THAT(done.err, HasSubstr("build/build-release.log"));
}

TEST_F(DeployScripts, ABuildThatDoesNotBeginSaysWhy) {
  set_up("echo 'ninja: error: loading build.ninja'; exit 1\n");
  EXPECT_THAT(build().err, HasSubstr("ninja: error: loading build.ninja\n"));
}

/// Returns what changed_files() of deploy/lib.sh says in a repository of three commits, of which CI noted the
/// last that passed.
TEST_F(DeployScripts, ChangesCountFromTheLastCommitThatPassed) {
  const std::string folder = folder_.path().string();
  const std::string script =
      ". deploy/lib.sh; top=" + folder + "; passed_commits=" + folder + R"(/cache/passed
    cd $top
    export GIT_CONFIG_GLOBAL=/dev/null GIT_AUTHOR_NAME=n GIT_AUTHOR_EMAIL=e GIT_COMMITTER_NAME=n GIT_COMMITTER_EMAIL=e
    commit() { echo "$1" >"$2"; git add "$2"; git commit -qm "$2"; }
    git init -q .
    commit 1 a; commit 1 b
    changed_files
    commit 1 c; note_passed
    commit 2 a; git rm -q b; git commit -qm gone
    changed_files
    # One that was refused, and is on no way to this one, counts for nothing.
    git checkout -q -b refused HEAD~2; commit 1 d; note_passed; git checkout -q -
    changed_files
    TESSERA_BASE=HEAD changed_files)";
  const support::Finished done = support::run_program({"/bin/bash", "-c", script}, std::chrono::seconds{60});
  EXPECT_EQ(done.err, "");
  EXPECT_EQ(done.out, "b\na\na\n");
}

}  // namespace
}  // namespace tessera
