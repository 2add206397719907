#include "command/jobs/on_done.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "command/exit_code.h"
#include "wire/enum_words.h"

extern char** environ;

namespace tessera::client {
namespace {

/// This program's environment, and these variables.
std::vector<std::string> environment_with(
    const std::array<std::pair<const char*, std::string>, 5>& variables) {
  std::vector<std::string> environment;
  for (const auto& [name, value] : variables) environment.push_back(absl::StrCat(name, "=", value));
  for (char** variable = environ; *variable != nullptr; ++variable) {
    bool replaced = false;
    for (const auto& [name, value] : variables)
      replaced = replaced || absl::StartsWith(*variable, absl::StrCat(name, "="));
    if (!replaced) environment.emplace_back(*variable);
  }
  return environment;
}

/// The status by waitpid; negative where the command could not be run.
int run_in_shell(const std::string& command, const std::vector<std::string>& environment) {
  // Made before the fork, after which nothing may be allocated.
  std::vector<char*> variables;
  for (const std::string& variable : environment) variables.push_back(const_cast<char*>(variable.c_str()));
  variables.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execle("/bin/sh", "sh", "-c", command.c_str(), nullptr, variables.data());
    _exit(127);
  }
  int status = -1;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

int OnDone::run(const v1::JobStatus& status, const std::string& output, int exit_code) const {
  if (command.empty()) return exit_code;
  const bool written = access(output.c_str(), F_OK) == 0;
  const int end = run_in_shell(command, environment_with({{{"TESSERA_JOB", status.job_id()},
                                                           {"TESSERA_NAME", status.name()},
                                                           {"TESSERA_STATE", wire::word_of(status.state())},
                                                           {"TESSERA_ERROR", status.error()},
                                                           {"TESSERA_OUTPUT", written ? output : ""}}}));
  if (end == 0 || exit_code != kDone) return exit_code;
  return report(kIncomplete,
                end > 0 && WIFEXITED(end)
                    ? absl::StrCat("--on-done: the command ended with exit code ", WEXITSTATUS(end))
                    : std::string("--on-done: the command was killed, or could not be run"));
}

void define_on_done_option(options::Command& command, std::string& value) {
  command
      .add("--on-done", value,
           "for /bin/sh when the job is over; TESSERA_JOB, TESSERA_NAME, TESSERA_STATE, TESSERA_ERROR and "
           "TESSERA_OUTPUT tell of it")
      .type_name("COMMAND");
}

}  // namespace tessera::client
