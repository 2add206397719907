#include "command/command_line.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <exception>
#include <utility>

#include "command/exit_code.h"

namespace tessera::client {

Option Option::required() {
  option_->required();
  return *this;
}

Option Option::with_default() {
  option_->capture_default_str();
  return *this;
}

Option Option::type_name(const char* name) {
  option_->type_name(name);
  return *this;
}

Option Option::in_range(std::uint64_t least, std::uint64_t most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

Option Option::one_of(std::vector<std::string> names) {
  option_->check(CLI::IsMember(std::move(names)));
  return *this;
}

Option Option::separated_by_commas() {
  option_->delimiter(',');
  return *this;
}

Option Option::one_value_each() {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::from_environment(const char* variable) {
  option_->envname(variable);
  return *this;
}

Option Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option Option::checked_by(std::function<std::string(const std::string&)> check) {
  option_->check(std::move(check));
  return *this;
}

Option Command::add(const char* name, std::string& value, const char* description) {
  return Option{*app_->add_option(name, value, description)};
}

Option Command::add(const char* name, std::int32_t& value, const char* description) {
  return Option{*app_->add_option(name, value, description)};
}

Option Command::add(const char* name, std::uint32_t& value, const char* description) {
  return Option{*app_->add_option(name, value, description)};
}

Option Command::add(const char* name, std::optional<std::uint32_t>& value, const char* description) {
  return Option{*app_->add_option(name, value, description)};
}

Option Command::add(const char* name, std::optional<double>& value, const char* description) {
  return Option{*app_->add_option(name, value, description)};
}

Option Command::add(const char* name, std::vector<std::uint32_t>& value, const char* description) {
  return Option{*app_->add_option(name, value, description)};
}

Option Command::add(const char* name, std::vector<std::string>& value, const char* description) {
  return Option{*app_->add_option(name, value, description)};
}

Option Command::add_read_by(const char* name, std::function<absl::Status(const std::string&)> take,
                            const char* description) {
  const auto read = [take = std::move(take), name](const std::string& text) {
    if (const absl::Status status = take(text); !status.ok()) {
      throw CLI::ValidationError{name, std::string{status.message()}};
    }
  };
  return Option{*app_->add_option_function<std::string>(name, read, description)};
}

Option Command::add_flag(const char* name, bool& value, const char* description) {
  return Option{*app_->add_flag(name, value, description)};
}

Option Command::option(const char* name) { return Option{*app_->get_option(name)}; }

void Command::does(Action action) {
  app_->callback([action = std::move(action), chosen = chosen_] { *chosen = action; });
}

absl::Status parse_options(const std::function<void(Command&)>& define, std::vector<std::string> arguments) {
  CLI::App parser;
  Action none;
  Command command{parser, none};
  define(command);
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes a vector from its end
  try {
    parser.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return absl::InvalidArgumentError(error.what());
  }
  return absl::OkStatus();
}

CommandLine::CommandLine(const char* program, const char* description, const char* footer, const std::string& version)
    : app_(std::make_unique<CLI::App>(description, program)) {
  app_->set_version_flag("--version", version);
  app_->require_subcommand(1);
  app_->footer(footer);
}

CommandLine::~CommandLine() = default;

Command CommandLine::add_command(const char* name, const char* description) {
  return Command{*app_->add_subcommand(name, description), chosen_};
}

int CommandLine::run(int argc, char** argv, Interrupt& interrupt) {
  try {
    app_->parse(argc, argv);
    return chosen_(interrupt);
  } catch (const CLI::ParseError& error) {
    return app_->exit(error) == 0 ? kDone : kUsage;
  } catch (const std::exception& error) {  // out of memory, above all
    return report(kIncomplete, error.what());
  }
}

}  // namespace tessera::client
