#include "bench/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

extern char** environ;

namespace tessera::client {
namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// The last line of a file, at most 300 bytes of it.
std::string last_line(std::FILE* file) {
  std::rewind(file);
  std::string line, last;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) {
    if (c == '\n') {
      if (!line.empty()) last = std::exchange(line, "");
    } else if (line.size() < 300) {
      line.push_back(static_cast<char>(c));
    }
  }
  return line.empty() ? last : line;
}

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

double cpu_seconds(const rusage& usage) { return seconds(usage.ru_utime) + seconds(usage.ru_stime); }

absl::StatusOr<ProcessCost> run_process(const std::vector<std::string>& words, std::stop_token stop) {
  if (words.empty()) return absl::InvalidArgumentError("there is no command");
  const std::unique_ptr<std::FILE, FileCloser> printed(std::tmpfile());
  if (printed == nullptr) return absl::InternalError(absl::StrCat("temporary file: ", std::strerror(errno)));
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, fileno(printed.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, fileno(printed.get()), STDERR_FILENO);
  // A group of its own: a shell's children are killed with it.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  const auto start = std::chrono::steady_clock::now();
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) return absl::InternalError(absl::StrCat(words[0], ": ", std::strerror(error)));

  // Not reaped yet, so that its number is nobody else's while it may be killed.
  siginfo_t ended{};
  {
    const std::stop_callback kill_it{stop, [child] { ::kill(-child, SIGKILL); }};
    while (::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
    }
  }
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  if (stop.stop_requested()) return absl::CancelledError("interrupted");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return absl::InternalError(absl::StrCat(words[0],
                                            WIFEXITED(status)
                                                ? absl::StrCat(" ended with exit code ", WEXITSTATUS(status))
                                                : absl::StrCat(" was ended by signal ", WTERMSIG(status)),
                                            ": ", last_line(printed.get())));
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  return ProcessCost{cpu_seconds(usage), wall.count()};
}

absl::StatusOr<std::string> fill_in(const std::string& command,
                                    const std::vector<std::pair<std::string, std::string>>& values) {
  std::string filled;
  for (std::size_t at = 0; at < command.size();) {
    const std::size_t end = command[at] == '{' ? command.find('}', at) : std::string::npos;
    const std::string name = end == std::string::npos ? "" : command.substr(at + 1, end - at - 1);
    if (name.empty() || name.find_first_not_of("abcdefghijklmnopqrstuvwxyz") != std::string::npos) {
      filled.push_back(command[at++]);
      continue;
    }
    const auto found = std::ranges::find(values, name, &std::pair<std::string, std::string>::first);
    if (found == values.end())
      return absl::InvalidArgumentError(absl::StrCat("{", name, "} stands for nothing"));
    absl::StrAppend(&filled, "'", absl::StrReplaceAll(found->second, {{"'", "'\\''"}}), "'");
    at = end + 1;
  }
  return filled;
}

}  // namespace tessera::client
