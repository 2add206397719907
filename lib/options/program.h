// The command line of a program: commands, options, help, and what is said when they are used wrongly. The
// same for all three programs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace tessera::options {

struct OptionSpec;
struct CommandSpec;

/// Exit code of a program whose command line makes no sense.
inline constexpr int kWrongUsage = 2;

/// A value that an option may have.
struct Choice {
  std::string name, meaning;
};

/// An option or an argument while it is being defined; every function says one thing more about it.
class Option {
 public:
  explicit Option(OptionSpec& spec) : spec_(&spec) {}

  Option required();
  /// --help tells the value that the variable has now.
  Option with_default();
  /// The same, where the value is another on each machine and for each user: what it means.
  Option with_default(const char* meaning);
  /// Name of the value in --help.
  Option type_name(const char* name);
  /// Both ends included.
  Option in_range(double least, double most);
  /// Names that --help lists, unless the description does.
  Option one_of(std::vector<std::string> names);
  /// Values, which --help names, with their meanings, which settings_of() tells; they are not checked.
  Option listing(std::vector<Choice> choices);
  /// The value is a list: "a,b,c".
  Option separated_by_commas();
  /// Takes the value from this variable where the option is not given.
  Option from_environment(const char* variable);
  /// Both together are refused.
  Option excludes(const Option& other);
  /// Refused without the other.
  Option needs(const Option& other);
  /// Words that shells offer as the value; they are not checked.
  Option completing(std::vector<std::string> words);
  /// Makes it a flag: what reads its text gets "" where the flag is given, or "on" or "off" by --set.
  Option as_flag();
  /// Leaves it out of --help: settings_of() tells of it. It is given by `--set NAME=VALUE`, where NAME is its
  /// long name without hyphens in front, or like other options.
  Option as_setting();
  /// A name that it had in an older version: it is taken, with a notice.
  Option formerly(std::string name);
  /// Refuses texts with the fault that `check` returns; sound ones have an empty one.
  Option checked_by(std::function<std::string(const std::string&)> check);

 private:
  OptionSpec* spec_;
};

/// A command while it is being defined. Names are "--name" or "-n,--name", or "NAME" for an argument, which
/// is taken in the order of definition; one of them may be a list. What parsing finds is put into the
/// variables, which must outlive the program's command line. Options of lists may be given several times; so
/// may flags. A command of two words ("token show") stands within the command of the first, which does
/// nothing by itself.
class Command {
 public:
  explicit Command(CommandSpec& spec) : spec_(&spec) {}

  /// The heading of --help under which the options are listed that follow.
  void group(const char* heading);
  /// A command line that --help shows.
  Command& example(const char* line);

  Option add(const char* name, std::string& value, const char* description = "");
  Option add(const char* name, std::int32_t& value, const char* description = "");
  Option add(const char* name, std::uint32_t& value, const char* description = "");
  Option add(const char* name, std::uint64_t& value, const char* description = "");
  Option add(const char* name, double& value, const char* description = "");
  Option add(const char* name, std::optional<std::uint32_t>& value, const char* description = "");
  Option add(const char* name, std::optional<double>& value, const char* description = "");
  Option add(const char* name, std::vector<std::uint32_t>& value, const char* description = "");
  Option add(const char* name, std::vector<std::string>& value, const char* description = "");
  /// A text that `take` reads; its error is the user's.
  Option add_read_by(const char* name, std::function<absl::Status(const std::string&)> take,
                     const char* description);
  /// The same for each element of a list, which `clear` empties.
  Option add_list_read_by(const char* name, std::function<absl::Status(const std::string&)> take,
                          std::function<void()> clear, const char* description);
  Option add_flag(const char* name, bool& value, const char* description);
  /// `--set NAME=VALUE`, which gives any other option by its long name.
  Option add_set(const char* description);
  /// One that was added before.
  Option option(const char* name);

  /// The options that the command line has given, as words: "--name=value" and flags. Those called `but_for`
  /// are left out, and so are arguments.
  std::vector<std::string> given(const std::vector<std::string>& but_for) const;

  /// Sets what Program::run does when the command line names this command.
  void runs(std::function<int()> action);

 private:
  CommandSpec* spec_;
};

/// Outcome of parsing a command line.
struct Outcome {
  std::optional<int> exit_code;  // absent: the options are set, and the program goes on
  std::string out, err;          // text to be printed
};

/// An option's value that a file of the user has: what the command line, or else a variable of the
/// environment, says goes before it.
struct FileValue {
  std::string option;    // "--spp"
  std::string text;      // a flag has "true" or "false"
  std::string place;     // "config.toml:3"
  bool expected = true;  // an error where the command has no such option
};
/// Reads the values for a command. Its error is the user's.
using DefaultsReader = std::function<absl::StatusOr<std::vector<FileValue>>(const std::string& command)>;

class Program {
 public:
  /// `footer` is shown under the list of commands.
  Program(const char* name, const char* description, const std::string& version, const char* footer = "");
  ~Program();

  /// Returns the only command of a program without named ones.
  Command root();
  /// The heading of --help under which the commands are listed that follow.
  void group(const char* heading);
  Command add_command(const char* name, const char* description);

  /// Commands have these values where nothing else gives them.
  void take_defaults_from(DefaultsReader read);

  /// A script with which a shell ("bash", "zsh", "fish") completes this program's commands, options and
  /// values. InvalidArgument for another shell.
  absl::StatusOr<std::string> completion(const std::string& shell) const;
  /// The manual page of the program, or of one of its commands, for man(1). InvalidArgument where there is no
  /// such command.
  absl::StatusOr<std::string> manual(const std::string& command) const;

  /// `words`: the command line without the program's name.
  Outcome parse(const std::vector<std::string>& words);
  /// The same, and prints what there is to say. The exit code with which the program ends, if it does.
  std::optional<int> parse(int argc, const char* const* argv);
  /// The same, then does what the command that was named does, and returns its exit code.
  int run(int argc, const char* const* argv);

 private:
  struct Parts;
  Outcome parse_command(const std::string& name, const std::vector<std::string>& rest);
  std::unique_ptr<Parts> parts_;
};

/// Tells all there is to know of the option that `define` defines and whose long name is `name`; of all whose
/// names begin with it and a period; or of all, a line each, where it is empty. NotFound, with the nearest
/// name, where there is none.
absl::StatusOr<std::string> settings_of(const std::function<void(Command&)>& define, const std::string& name);

/// Takes `words` ("--name", "value" ...) as the options that `define` defines. InvalidArgument says what is
/// wrong.
absl::Status parse_options(const std::function<void(Command&)>& define,
                           const std::vector<std::string>& words);

}  // namespace tessera::options
