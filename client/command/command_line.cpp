#include "command/command_line.h"

#include <exception>
#include <utility>

#include "command/exit_code.h"
#include "command/setup/config_file.h"
#include "wire/version.h"

namespace tessera::client {

void Command::does(Action action) {
  runs([action = std::move(action), interrupt = interrupt_] { return action(*interrupt); });
}

CommandLine::CommandLine(Interrupt& interrupt)
    : program_(
          "tessera", "Renders scenes, in this process or on a farm of workers.", wire::build_version(),
          "Exit codes: 0 done, 2 usage, 3 bad scene, 4 cannot reach or refused, 5 job failed, 6 incomplete, "
          "7 image with marked holes (tessera retry), 8 frames failed, 9 doctor found a fault, 10 image not "
          "denoised, 130 interrupted."),
      interrupt_(&interrupt) {
  program_.take_defaults_from(
      [](const std::string& command) -> absl::StatusOr<std::vector<options::FileValue>> {
        // These mend the file, or say what is wrong with it.
        if (command == "config" || command == "doctor" || command == "init")
          return std::vector<options::FileValue>{};
        const absl::StatusOr<std::vector<ConfigValue>> config = read_config(config_path());
        if (!config.ok()) return config.status();
        return values_for(command, *config);
      });
}

Command CommandLine::add_command(const char* name, const char* description) {
  return Command{program_.add_command(name, description), *interrupt_};
}

int CommandLine::run(int argc, const char* const* argv) {
  try {
    return program_.run(argc, argv);
  } catch (const std::exception& error) {  // out of memory, above all
    return report(kIncomplete, error.what());
  }
}

}  // namespace tessera::client
