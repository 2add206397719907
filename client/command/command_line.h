// What the subcommands see of the command-line parser. CLI11 is templates in headers, nine seconds of the compiler's
// time a file: only command_line.cpp includes them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tessera::client {

class Interrupt;

/// Does the work of a subcommand and returns the exit code.
using Action = std::function<int(Interrupt&)>;

/// An option or an argument while it is being defined; every function says one thing more about it.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option required();
  /// --help tells the value that the variable has now.
  Option with_default();
  /// Of the value, in --help.
  Option type_name(const char* name);
  /// Both ends included.
  Option in_range(std::uint64_t least, std::uint64_t most);
  Option one_of(std::vector<std::string> names);
  /// The value is a list: "a,b,c".
  Option separated_by_commas();
  /// Takes one value each time it is given, where several words would fit.
  Option one_value_each();
  /// What to take where the option is not given.
  Option from_environment(const char* variable);
  /// Both together are refused.
  Option excludes(const Option& other);
  /// What `check` has to say against a text; nothing when it is well.
  Option checked_by(std::function<std::string(const std::string&)> check);

 private:
  CLI::Option* option_;
};

/// A subcommand while it is being defined. Names are "--name" or "-n,--name", or "NAME" for an argument. What parsing
/// finds is put into the variables, which must outlive the command line: commonly the action shares their ownership.
class Command {
 public:
  Command(CLI::App& app, Action& chosen) : app_(&app), chosen_(&chosen) {}

  Option add(const char* name, std::string& value, const char* description = "");
  Option add(const char* name, std::int32_t& value, const char* description = "");
  Option add(const char* name, std::uint32_t& value, const char* description = "");
  Option add(const char* name, std::optional<std::uint32_t>& value, const char* description = "");
  Option add(const char* name, std::optional<double>& value, const char* description = "");
  Option add(const char* name, std::vector<std::uint32_t>& value, const char* description = "");
  Option add(const char* name, std::vector<std::string>& value, const char* description = "");
  /// A text that `take` reads; its error is the user's.
  Option add_read_by(const char* name, std::function<absl::Status(const std::string&)> take, const char* description);
  Option add_flag(const char* name, bool& value, const char* description);
  /// One that was added before.
  Option option(const char* name);

  /// What is to be done when the command line names this subcommand.
  void does(Action action);

 private:
  CLI::App* app_;
  Action* chosen_;
};

/// Takes `arguments` ("--name", "value" ...) as a command line with the options that `define` defines. InvalidArgument
/// says what is wrong with them.
absl::Status parse_options(const std::function<void(Command&)>& define, std::vector<std::string> arguments);

class CommandLine {
 public:
  CommandLine(const char* program, const char* description, const char* footer, const std::string& version);
  ~CommandLine();

  Command add_command(const char* name, const char* description);

  /// Parses, does what was asked for, and returns the exit code. Help and errors of usage are printed.
  int run(int argc, char** argv, Interrupt& interrupt);

 private:
  std::unique_ptr<CLI::App> app_;
  Action chosen_;
};

}  // namespace tessera::client
