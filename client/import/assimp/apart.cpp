#include "import/assimp/apart.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>
#include <utility>

#include "import/input/concat.h"

namespace tessera::client::assimp {
namespace {

constexpr int kDone = 0, kNoMemory = 3;  // exit codes of the process

absl::Status failed(const char* call) {
  return absl::InternalError(concat("a process of its own: ", call, ": ", std::strerror(errno)));
}

std::uint64_t address_space() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit(decltype(RLIMIT_AS) resource, std::uint64_t most) {
  const rlimit value{most, most};
  setrlimit(resource, &value);
}

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// The whole life of the process.
[[noreturn]] void live(const ProcessBounds& bounds, const std::function<std::string()>& work, int file) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGXCPU}) std::signal(signal, SIG_DFL);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_AS, address_space() + bounds.memory_bytes);
  limit(RLIMIT_CPU, bounds.cpu_seconds);
  int code = kNoMemory;
  try {
    if (write_all(file, work())) code = kDone;
  } catch (const std::exception&) {
  }
  // Nothing of this process's own is to be cleaned up by its copy.
  _exit(code);
}

absl::StatusOr<std::string> read_whole(int file) {
  const off_t size = lseek(file, 0, SEEK_END);
  if (size < 0) return failed("lseek");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t got = pread(file, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return failed("pread");
    at += static_cast<std::size_t>(got);
  }
  return bytes;
}

absl::StatusOr<std::string> run_into(int file, const ProcessBounds& bounds,
                                     const std::function<std::string()>& work) {
  const pid_t process = fork();
  if (process < 0) return failed("fork");
  if (process == 0) live(bounds, work, file);
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return failed("waitpid");
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == kDone) return read_whole(file);
  const bool too_long = WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
  if (too_long) return absl::ResourceExhaustedError(concat("it takes more than ", bounds.cpu_seconds, " s"));
  if (WIFEXITED(status))
    return absl::ResourceExhaustedError(concat("it takes more than ", bounds.memory_bytes, " bytes"));
  return absl::ResourceExhaustedError(
      concat("what reads it ended with signal ", WTERMSIG(status), " (", strsignal(WTERMSIG(status)), ")"));
}

}  // namespace

absl::StatusOr<std::string> run_apart(const ProcessBounds& bounds, const std::function<std::string()>& work) {
  const int file = memfd_create("tessera-apart", MFD_CLOEXEC);
  if (file < 0) return failed("memfd_create");
  absl::StatusOr<std::string> result = run_into(file, bounds, work);
  close(file);
  return result;
}

}  // namespace tessera::client::assimp
