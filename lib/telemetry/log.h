// The log of a program: lines for people, or JSON objects for machines, from the same calls. A line that
// concerns a job, a unit, a worker says so in fields; spdlog's own calls are for lines that concern none.
#pragma once

#include <spdlog/spdlog.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera::telemetry {

/// Fields that say what a line is about. Those that are absent or empty are left out.
struct LogFields {
  std::string_view job = {};
  std::optional<std::uint32_t> unit = {};
  std::optional<std::uint32_t> attempt = {};  // names one lease, together with the job and the unit
  std::string_view worker = {};               // its name, not its registration
  std::string_view host = {};
  std::string_view user = {};
  std::string_view peer = {};  // address of the other end of a connection
};

/// The calling thread's lines are about `fields`, which must live as long as this.
class LogAbout {
 public:
  explicit LogAbout(const LogFields& fields);
  ~LogAbout();
  LogAbout(const LogAbout&) = delete;
  LogAbout& operator=(const LogAbout&) = delete;

 private:
  const LogFields* const outer_;
};

template <class... Args>
void log(spdlog::level::level_enum level, const LogFields& fields, spdlog::format_string_t<Args...> text,
         Args&&... args) {
  const LogAbout about{fields};
  spdlog::log(level, text, std::forward<Args>(args)...);
}

enum class LogFormat {
  kText,  // "[2026-01-31 12:00:00.000] [tessera-worker] [info] message job=4f0c unit=7": local time
  kJson,  // {"time":"2026-01-31T12:00:00.000Z","level":"info","program":...,"message":...,"job":...,"unit":7},
          // one a line
};

/// Names of the formats and the levels on command lines.
inline const std::vector<std::string> kLogFormats{"text", "json"};
inline const std::vector<std::string> kLogLevels{"trace", "debug",    "info", "warning",
                                                 "error", "critical", "off"};

struct LogOptions {
  std::string program;
  std::string level = "info";   // one of kLogLevels
  std::string format = "text";  // one of kLogFormats
  std::string worker = {};      // the name of the worker that this process is; every line says it
};

/// From here on, the process's lines go to standard error in this way.
void set_up_log(const LogOptions& options);

/// Lines cannot be forged by what they quote: control characters are escaped, and so is, in JSON, what is not
/// UTF-8.
std::unique_ptr<spdlog::formatter> make_log_formatter(LogFormat format, std::string worker);

}  // namespace tessera::telemetry
