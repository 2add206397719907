#include "support/process/process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

extern char** environ;

namespace tessera::support {
namespace {

/// A pipe whose ends are closed when the child executes another program.
std::pair<int, int> make_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::system_error{errno, std::generic_category(), "pipe"};
  return {ends[0], ends[1]};
}

/// Whether a sanitizer has found something. Not its complaints about too little memory, which lack the colon.
bool has_sanitizer_report(const std::string& err) {
  return err.find("Sanitizer: ") != std::string::npos || err.find(": runtime error: ") != std::string::npos;
}

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> result;
  for (std::string& string : strings) result.push_back(string.data());
  result.push_back(nullptr);
  return result;
}

}  // namespace

Process::Process(std::vector<std::string> command, std::vector<std::string> environment) {
  // Programs take either of two values of one variable.
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view own{*variable}, name = own.substr(0, own.find('=') + 1);
    if (std::none_of(environment.begin(), environment.end(),
                     [&](const std::string& given) { return given.starts_with(name); })) {
      environment.emplace_back(own);
    }
  }
  // Nothing may be allocated between fork and exec: another thread may hold the heap's lock.
  std::vector<char*> arguments = pointers(command);
  std::vector<char*> variables = pointers(environment);
  const auto [out_read, out_write] = make_pipe();
  const auto [err_read, err_write] = make_pipe();

  pid_ = ::fork();
  if (pid_ < 0) throw std::system_error{errno, std::generic_category(), "fork"};
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::dup2(out_write, STDOUT_FILENO);
    ::dup2(err_write, STDERR_FILENO);
    ::execve(arguments[0], arguments.data(), variables.data());
    _exit(127);
  }
  ::close(out_write);
  ::close(err_write);
  threads_.emplace_back([this, out_read = out_read] { collect(out_read, out_); });
  threads_.emplace_back([this, err_read = err_read] { collect(err_read, err_); });
  threads_.emplace_back([this] { reap(); });
}

Process::~Process() {
  kill();
  threads_.clear();
  // Most programs of a test are killed in the end, or started again when they die: no exit code would tell.
  if (has_sanitizer_report(err_)) ADD_FAILURE() << "a sanitizer's report:\n" << err_;
}

void Process::send_signal(int signal) {
  std::lock_guard lock{mutex_};
  // Not reaped yet, so that the id is still this program's.
  if (!ended_) ::kill(pid_, signal);
}

void Process::collect(int descriptor, std::string& into) {
  char buffer[4096];
  while (true) {
    const ssize_t got = ::read(descriptor, buffer, sizeof(buffer));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    std::lock_guard lock{mutex_};
    into.append(buffer, static_cast<std::size_t>(got));
    changed_.notify_all();
  }
  ::close(descriptor);
  std::lock_guard lock{mutex_};
  --open_pipes_;
  changed_.notify_all();
}

void Process::reap() {
  // Waits without reaping first: between the end and the entry in `ended_` nobody may signal a number that is
  // free again.
  siginfo_t info{};
  while (::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
  }
  std::lock_guard lock{mutex_};
  int status = 0;
  ::waitpid(pid_, &status, 0);
  ended_ = WIFEXITED(status) ? ExitStatus{WEXITSTATUS(status), 0} : ExitStatus{-1, WTERMSIG(status)};
  changed_.notify_all();
}

std::optional<ExitStatus> Process::wait(std::chrono::milliseconds patience) {
  std::unique_lock lock{mutex_};
  changed_.wait_for(lock, patience, [this] { return ended_ && open_pipes_ == 0; });
  return ended_;
}

std::optional<std::string> Process::wait_for_line(const std::string& prefix,
                                                  std::chrono::milliseconds patience) {
  std::optional<std::string> rest;
  const auto find = [&] {
    for (std::size_t begin = 0, end; (end = out_.find('\n', begin)) != std::string::npos; begin = end + 1) {
      if (out_.compare(begin, prefix.size(), prefix) == 0) {
        rest = out_.substr(begin + prefix.size(), end - begin - prefix.size());
        return true;
      }
    }
    return ended_.has_value() && open_pipes_ == 0;
  };
  std::unique_lock lock{mutex_};
  changed_.wait_for(lock, patience, find);
  return rest;
}

bool Process::wait_for_err(const std::string& text, std::chrono::milliseconds patience) {
  const auto found = [&] { return err_.find(text) != std::string::npos; };
  std::unique_lock lock{mutex_};
  changed_.wait_for(lock, patience, [&] { return found() || (ended_ && open_pipes_ == 0); });
  return found();
}

std::string Process::out() const {
  std::lock_guard lock{mutex_};
  return out_;
}

std::string Process::err(std::size_t from) const {
  std::lock_guard lock{mutex_};
  return err_.substr(std::min(from, err_.size()));
}

Finished run_program(std::vector<std::string> command, std::chrono::milliseconds patience,
                     std::vector<std::string> environment) {
  Process process{std::move(command), std::move(environment)};
  if (!process.wait(patience)) {
    process.kill();
    process.wait(std::chrono::seconds{5});
  }
  return {process.wait(std::chrono::seconds{5}).value_or(ExitStatus{}), process.out(), process.err()};
}

}  // namespace tessera::support
