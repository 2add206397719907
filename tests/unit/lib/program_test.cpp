#include "options/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "absl/strings/str_split.h"

namespace tessera::options {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct Values {
  std::string scene, output, kind = "plain", tls, join;
  std::string way, place = "here";
  std::optional<double> step;
  bool view = false;
  std::vector<std::string> tags;
  std::vector<std::uint32_t> counts{4, 16};
  std::int32_t priority = 0;
  std::optional<std::uint32_t> spp;
  std::optional<double> noise;
  bool quiet = false;
};

void define(Command& command, Values& values) {
  command.add("SCENE", values.scene, "the scene file").required();
  command.add("-o,--output", values.output, "the image").type_name("FILE").required();
  command.group("Quality");
  command.add("--spp", values.spp, "samples a pixel").in_range(1, 65536);
  command.add("--noise", values.noise, "relative error");
  command.add("--kind", values.kind, "how it is done").one_of({"plain", "fancy"}).with_default();
  command.add("--way", values.way, "how it goes").listing({{"up", "to the left"}, {"down", "to the right"}});
  command.add("--counts", values.counts, "several").separated_by_commas().in_range(1, 100).with_default();
  command.add("--tag", values.tags, "names").separated_by_commas();
  command.add("--priority", values.priority, "higher goes first").with_default();
  command.add("--at", values.place, "where it is done").with_default("next to you");
  const Option tls = command.add("--tls", values.tls, "certificates").from_environment("TESSERA_TEST_TLS");
  command.add("--join", values.join, "a token").needs(tls);
  command.add_flag("-q,--quiet", values.quiet, "no progress").excludes(command.option("--noise"));
  command.group("Integrator mlt");
  command.add("--mlt.step", values.step, "how far it goes")
      .as_setting()
      .formerly("--mutation-step")
      .in_range(0, 1);
  command.add_flag("--mlt.view", values.view, "shows it").as_setting();
  command.group("Quality");
  command.add_set("any other");
  command.example("draw render box.pbrt -o box.exr");
}

/// A program `draw` with the commands `render` and `resume`.
class ProgramTest : public ::testing::Test {
 protected:
  ProgramTest() {
    Command render = program_.add_command("render", "Renders a scene");
    define(render, values_);
    program_.add_command("resume", "Goes on");
  }

  /// Error message for these words, which must be wrong.
  std::string fault(const std::vector<std::string>& words) {
    const Outcome outcome = program_.parse(words);
    EXPECT_EQ(outcome.exit_code, kWrongUsage);
    EXPECT_EQ(outcome.out, "");
    return outcome.err;
  }
  std::string fault_of_render(std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "box.pbrt", "-o", "box.exr"});
    return fault(words);
  }

  Values values_;
  Program program_{"draw", "Draws.", "1.0"};
};

TEST_F(ProgramTest, TakesValuesInEveryForm) {
  const Outcome outcome = program_.parse({"render", "--spp=64", "box.pbrt", "-obox.exr", "--tag", "a,b",
                                          "--tag", "c", "--counts", "1,2,3", "--priority", "-5", "-q"});
  EXPECT_FALSE(outcome.exit_code) << outcome.err;
  EXPECT_EQ(values_.scene, "box.pbrt");
  EXPECT_EQ(values_.output, "box.exr");
  EXPECT_EQ(values_.spp, 64u);
  EXPECT_THAT(values_.tags, ElementsAre("a", "b", "c"));
  EXPECT_THAT(values_.counts, ElementsAre(1, 2, 3)) << "what was there by default is gone";
  EXPECT_EQ(values_.priority, -5);
  EXPECT_TRUE(values_.quiet);
}

TEST_F(ProgramTest, GivesAListOfArgumentsWhatTheOthersLeave) {
  std::vector<std::string> jobs;
  std::int32_t priority = 0;
  Command command = program_.add_command("priority", "Changes priorities");
  command.add("ID", jobs).required();
  command.add("PRIORITY", priority).required();
  EXPECT_FALSE(program_.parse({"priority", "a", "b", "-5"}).exit_code);
  EXPECT_THAT(jobs, ElementsAre("a", "b"));
  EXPECT_EQ(priority, -5);
  EXPECT_THAT(program_.parse({"priority", "--help"}).out, HasSubstr("usage: draw priority ID... PRIORITY\n"));
}

TEST_F(ProgramTest, TakesAnEmptyValueForWhatItIs) {
  EXPECT_FALSE(program_.parse({"render", "--tls=", "box.pbrt", "--output=", "--tag", ""}).exit_code);
  EXPECT_EQ(values_.scene, "box.pbrt");
  EXPECT_THAT(values_.tags, ElementsAre(""));
  EXPECT_THAT(fault_of_render({"--spp="}),
              HasSubstr("--spp: expected a whole number from 1 to 65536, not ''"));
}

TEST_F(ProgramTest, TakesNumbersInBaseTenOnly) {
  EXPECT_FALSE(program_.parse({"render", "box.pbrt", "-o", "box.exr", "--spp", "0010"}).exit_code);
  EXPECT_EQ(values_.spp, 10u);
  EXPECT_THAT(fault_of_render({"--spp", "0x10"}), HasSubstr("--spp: expected"));
  EXPECT_THAT(fault_of_render({"--counts", "1,,2"}), HasSubstr("--counts: expected"));
}

TEST_F(ProgramTest, LeavesBracketsInValuesAlone) {
  EXPECT_FALSE(program_.parse({"render", "box.pbrt", "-o", "[c]", "--tag", "[d]"}).exit_code);
  EXPECT_EQ(values_.output, "[c]");
  EXPECT_THAT(values_.tags, ElementsAre("[d]"));
}

TEST_F(ProgramTest, TakesShortFlagsTogetherWithAnOption) {
  EXPECT_FALSE(program_.parse({"render", "box.pbrt", "-qobox.exr"}).exit_code);
  EXPECT_TRUE(values_.quiet);
  EXPECT_EQ(values_.output, "box.exr");
}

TEST_F(ProgramTest, TakesAWordWithADashBehindTwoDashes) {
  EXPECT_FALSE(program_.parse({"render", "-o", "box.exr", "--", "--scene.pbrt"}).exit_code);
  EXPECT_EQ(values_.scene, "--scene.pbrt");
}

TEST_F(ProgramTest, NamesTheNearestCommandAndItsUsageInOneLine) {
  EXPECT_EQ(fault({"rendr"}),
            "draw: there is no command 'rendr'; did you mean 'render'?\n"
            "usage: draw COMMAND [options]   (more: draw --help)\n");
  EXPECT_THAT(fault({}), HasSubstr("a command is missing"));
  EXPECT_THAT(fault({"help", "rendr"}), HasSubstr("did you mean 'render'?"));
}

TEST_F(ProgramTest, NamesTheNearestOption) {
  EXPECT_EQ(fault_of_render({"--nosie", "0.1"}),
            "draw render: there is no option '--nosie'; did you mean '--noise'?\n"
            "usage: draw render SCENE -o FILE [options]   (more: draw render --help)\n");
  // Not that --output is missing: the one that is there is what is wrong.
  EXPECT_THAT(fault({"render", "box.pbrt", "--outptu", "x.exr"}),
              HasSubstr("'--outptu'; did you mean '--output'?"));
}

TEST_F(ProgramTest, SaysWhatWasExpectedInPlainWords) {
  EXPECT_THAT(fault_of_render({"--spp", "abc"}),
              StartsWith("draw render: --spp: expected a whole number from 1 to 65536, not 'abc'\n"));
  EXPECT_THAT(fault_of_render({"--priority", "1.5"}),
              HasSubstr("--priority: expected a whole number, not '1.5'"));
  EXPECT_THAT(fault_of_render({"--kind", "fnacy"}),
              HasSubstr("--kind: there is no 'fnacy'; there is: plain, fancy"));
}

TEST_F(ProgramTest, RefusesNumbersThatAreNone) {
  for (const char* number : {"0", "65537", "-1", "", "1x", "99999999999999999999"}) {
    EXPECT_THAT(fault_of_render({"--spp", number}), HasSubstr("--spp: expected")) << number;
  }
}

TEST_F(ProgramTest, RefusesRealNumbersThatAreNotFinite) {
  for (const char* number : {"nan", "inf", "1e999", "half"}) {
    EXPECT_THAT(fault_of_render({"--noise", number}), HasSubstr("--noise: expected a number")) << number;
  }
}

TEST_F(ProgramTest, SaysWhatIsGivenTwiceOrIsTooMuchOrMissing) {
  EXPECT_THAT(fault({"render", "a", "-o", "b", "--output", "c"}), HasSubstr("--output is given twice"));
  EXPECT_THAT(fault_of_render({"other.pbrt"}), HasSubstr("'other.pbrt' is one word too many"));
  EXPECT_THAT(fault({"render"}), HasSubstr("SCENE is required"));
  EXPECT_THAT(fault({"render", "a"}), HasSubstr("--output is required"));
  EXPECT_THAT(fault({"render", "-o", "b"}), HasSubstr("SCENE is required"));
  EXPECT_THAT(fault({"render", "a", "-o"}), HasSubstr("-o needs a value: -o FILE"));
  EXPECT_THAT(fault({"render", "a", "-o", "--quiet"}), HasSubstr("--output needs a value: --output FILE"));
  EXPECT_THAT(fault_of_render({"--quiet=yes"}), HasSubstr("--quiet takes no value"));
}

TEST_F(ProgramTest, SaysWhatGoesTogether) {
  EXPECT_THAT(fault_of_render({"--quiet", "--noise", "0.1"}), HasSubstr("--quiet excludes --noise"));
  EXPECT_THAT(fault_of_render({"--join", "token"}), HasSubstr("--join requires --tls"));
}

TEST_F(ProgramTest, TakesFromTheEnvironmentWhatIsNotGiven) {
  ::setenv("TESSERA_TEST_TLS", "folder", 1);
  EXPECT_FALSE(program_.parse({"render", "a", "-o", "b", "--join", "token"}).exit_code);
  EXPECT_EQ(values_.tls, "folder");
  ::unsetenv("TESSERA_TEST_TLS");
}

TEST_F(ProgramTest, NamesTheVariableThatHoldsAWrongValue) {
  std::uint32_t port = 0;
  program_.add_command("serve", "Serves")
      .add("--port", port)
      .in_range(1, 65535)
      .from_environment("TESSERA_TEST_PORT");
  ::setenv("TESSERA_TEST_PORT", "many", 1);
  EXPECT_THAT(fault({"serve"}),
              HasSubstr("$TESSERA_TEST_PORT: expected a whole number from 1 to 65535, not 'many'"));
  EXPECT_FALSE(program_.parse({"serve", "--port", "80"}).exit_code);
  ::unsetenv("TESSERA_TEST_PORT");
  EXPECT_EQ(port, 80u);
}

TEST_F(ProgramTest, HelpsWithinEightyColumnsInGroupsWithAnExample) {
  const Outcome outcome = program_.parse({"render", "--no-such", "--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, StartsWith("Renders a scene\n\nusage: draw render SCENE -o FILE [options]\n"));
  EXPECT_THAT(outcome.out,
              HasSubstr("\nQuality\n      --spp N               samples a pixel (1 to 65536)\n"));
  EXPECT_THAT(outcome.out, HasSubstr("how it is done (plain, fancy; default: plain)"));
  EXPECT_THAT(outcome.out, HasSubstr("where it is done (default: next to you)"));
  EXPECT_THAT(outcome.out, HasSubstr("      --way TEXT            how it goes (up, down)\n"));
  EXPECT_THAT(outcome.out, EndsWith("for example\n  draw render box.pbrt -o box.exr\n"));
  for (const std::string& line : std::vector<std::string>(absl::StrSplit(outcome.out, '\n'))) {
    EXPECT_LE(line.size(), 80u) << line;
  }
  EXPECT_EQ(program_.parse({"help", "render"}).out, outcome.out);
}

TEST_F(ProgramTest, SettingsAreLeftOutOfHelpAndGivenBySetOrLikeOtherOptions) {
  const std::string help = program_.parse({"help", "render"}).out;
  EXPECT_THAT(help, Not(HasSubstr("mlt")));
  EXPECT_THAT(help, HasSubstr("      --set NAME=VALUE      any other\n"));
  const auto step = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "box.pbrt", "-o", "box.exr"});
    values_.step.reset();
    const Outcome outcome = program_.parse(words);
    EXPECT_FALSE(outcome.exit_code) << outcome.err;
    return std::pair(values_.step, outcome.err);
  };
  EXPECT_EQ(step({"--set", "mlt.step=0.5"}), std::pair(std::optional(0.5), std::string()));
  EXPECT_EQ(step({"--set=mlt.step=0.25", "--set", "spp=9"}), std::pair(std::optional(0.25), std::string()));
  EXPECT_EQ(values_.spp, 9u) << "options are settings, too";
  EXPECT_EQ(step({"--mlt.step", "0.75"}), std::pair(std::optional(0.75), std::string()));
  EXPECT_EQ(
      step({"--mutation-step=1"}),
      std::pair(std::optional(1.0), std::string("note: --mutation-step is --set mlt.step=X from now on\n")));
  EXPECT_FALSE(values_.view);
  step({"--set", "mlt.view"});
  EXPECT_TRUE(values_.view);
  step({"--set", "mlt.view=off"});
  EXPECT_FALSE(values_.view);
  EXPECT_THAT(fault_of_render({"--set", "mlt.stp=1"}),
              HasSubstr("there is no setting 'mlt.stp'; did you mean 'mlt.step'"));
  EXPECT_THAT(fault_of_render({"--set", "mlt.step"}),
              HasSubstr("--set mlt.step needs a value: --set mlt.step=X"));
  EXPECT_THAT(fault_of_render({"--set", "mlt.step=2"}),
              HasSubstr("mlt.step: expected a number from 0 to 1, not '2'"));
  EXPECT_THAT(fault_of_render({"--set", "mlt.view=maybe"}), HasSubstr("mlt.view is on or off, not 'maybe'"));
  EXPECT_THAT(fault_of_render({"--set", "spp=4", "--spp", "4"}), HasSubstr("--spp is given twice"));
  EXPECT_THAT(fault_of_render({"--set", "set=4"}), HasSubstr("there is no setting 'set'"));
}

TEST(SettingsOf, TellsOfOneOfAGroupOrOfAll) {
  Values values;
  const auto define_all = [&](Command& command) { define(command, values); };
  const std::string one = *settings_of(define_all, "way");
  EXPECT_EQ(one,
            "how it goes\n\n  --set way=TEXT\n  --way TEXT\n\n"
            "  up                        to the left\n  down                      to the right\n");
  EXPECT_THAT(*settings_of(define_all, "mlt.step"), HasSubstr("--mutation-step in older versions"));
  EXPECT_EQ(*settings_of(define_all, "mlt"),
            "Integrator mlt\n  mlt.step=X                how far it goes (0 to 1)\n"
            "  mlt.view                  shows it\n");
  EXPECT_THAT(*settings_of(define_all, ""), HasSubstr("\nQuality\n  spp=N "));
  EXPECT_THAT(std::string(settings_of(define_all, "mlt.stap").status().message()), HasSubstr("mlt.step"));
}

TEST_F(ProgramTest, ListsItsCommands) {
  const Outcome outcome = program_.parse({"--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("  render          Renders a scene\n"));
  EXPECT_EQ(program_.parse({"--version"}).out, "1.0\n");
}

TEST_F(ProgramTest, HasCommandsWithinCommands) {
  program_.add_command("field", "Keeps rays").example("draw field grow x");
  std::string where;
  Command grow = program_.add_command("field grow", "Adds to a field");
  grow.add("WHERE", where).required();
  grow.runs([&] { return where == "x" ? 7 : 0; });
  const char* const words[] = {"draw", "field", "grow", "x"};
  EXPECT_EQ(program_.run(4, words), 7);
  EXPECT_THAT(program_.parse({"--help"}).out, AllOf(HasSubstr("  field "), Not(HasSubstr("field grow"))));
  const std::string family = program_.parse({"field", "--help"}).out;
  EXPECT_THAT(family, HasSubstr("usage: draw field COMMAND [options]"));
  EXPECT_THAT(family, HasSubstr("  grow            Adds to a field\n"));
  EXPECT_THAT(program_.parse({"field", "grow", "--help"}).out, HasSubstr("usage: draw field grow WHERE"));
  EXPECT_EQ(program_.parse({"help", "field", "grow"}).out, program_.parse({"field", "grow", "--help"}).out);
  EXPECT_THAT(fault({"field", "grwo"}), HasSubstr("there is no command 'grwo'; did you mean 'grow'?"));
  EXPECT_THAT(fault({"field"}), HasSubstr("draw field: a command is missing"));
  EXPECT_EQ(*program_.manual("field-grow"), *program_.manual("field grow"));
}

TEST_F(ProgramTest, RunsWhatTheCommandDoes) {
  int code = 0;
  program_.add_command("count", "Counts").runs([&] { return code = 42; });
  const char* const words[] = {"draw", "count"};
  EXPECT_EQ(program_.run(2, words), 42);
}

TEST(ParseOptions, TakesOptionsAlone) {
  std::optional<std::uint32_t> spp;
  const auto define_one = [&](Command& command) { command.add("--spp", spp).in_range(1, 9); };
  EXPECT_TRUE(parse_options(define_one, {"--spp", "4"}).ok());
  EXPECT_EQ(spp, 4u);
  EXPECT_EQ(parse_options(define_one, {"--spp", "10"}).message(),
            "--spp: expected a whole number from 1 to 9, not '10'");
}

TEST_F(ProgramTest, TakesWhatAFileSaysWhereNothingElseDoes) {
  program_.take_defaults_from([](const std::string& command) -> absl::StatusOr<std::vector<FileValue>> {
    EXPECT_EQ(command, "render");
    return std::vector<FileValue>{{"--spp", "8", "a:1"},
                                  {"--counts", "7,9", "a:2"},
                                  {"--quiet", "true", "a:3"},
                                  {"--unknown", "1", "a:4", false},
                                  {"--tls", "file", "a:5"}};
  });
  ::setenv("TESSERA_TEST_TLS", "environment", 1);
  const Outcome outcome = program_.parse({"render", "a.pbrt", "-o", "a.exr", "--counts", "3"});
  ::unsetenv("TESSERA_TEST_TLS");
  EXPECT_EQ(outcome.exit_code, std::nullopt) << outcome.err;
  EXPECT_EQ(values_.spp, 8u);
  EXPECT_THAT(values_.counts, ElementsAre(3u));
  EXPECT_TRUE(values_.quiet);
  EXPECT_EQ(values_.tls, "environment");
}

TEST_F(ProgramTest, NamesThePlaceOfAFilesFault) {
  const auto fault_of = [&](const FileValue& value) {
    program_.take_defaults_from([value](const std::string&) { return std::vector<FileValue>{value}; });
    return fault({"render", "a.pbrt", "-o", "a.exr"});
  };
  EXPECT_THAT(fault_of({"--spp", "0", "file:7"}), HasSubstr("file:7: --spp: expected a whole number from 1"));
  EXPECT_THAT(fault_of({"--sppp", "1", "file:8"}), HasSubstr("file:8: draw render has no option '--sppp'"));
  EXPECT_THAT(fault_of({"--quiet", "perhaps", "file:9"}), HasSubstr("file:9: --quiet is true or false"));
}

TEST_F(ProgramTest, CompletesCommandsOptionsAndValues) {
  const std::string bash = *program_.completion("bash");
  EXPECT_THAT(bash, HasSubstr("compgen -W 'render resume'"));
  EXPECT_THAT(bash, HasSubstr("render) options='--help -o --output"));
  EXPECT_THAT(bash, HasSubstr("'render --kind'|'render kind') values='plain fancy' ;;"));
  EXPECT_THAT(bash, HasSubstr("'render --way'|'render way') values='up down' ;;"));
  EXPECT_THAT(*program_.completion("zsh"), HasSubstr("'--kind[how it is done]:TEXT:(plain fancy)'"));
  EXPECT_THAT(*program_.completion("fish"), HasSubstr("-l kind -r -f -a 'plain fancy' -d 'how it is done'"));
  EXPECT_FALSE(program_.completion("csh").ok());
  EXPECT_EQ(program_.parse({"--completion", "bash"}).out, bash);
}

TEST_F(ProgramTest, HasManualPages) {
  EXPECT_THAT(*program_.manual(""), HasSubstr(".BR draw\\-render (1)"));
  const std::string page = *program_.manual("render");
  EXPECT_THAT(page, HasSubstr(".B \\-\\-spp N\nsamples a pixel (1 to 65536)"));
  EXPECT_THAT(page, HasSubstr(".SH EXAMPLES"));
  EXPECT_FALSE(program_.manual("reander").ok());
}

}  // namespace
}  // namespace tessera::options
