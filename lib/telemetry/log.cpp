#include "telemetry/log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "base/printable.h"
#include "telemetry/recent_lines.h"

namespace tessera::telemetry {
namespace {

thread_local const LogFields* fields_of_thread = nullptr;

void append(std::string_view text, spdlog::memory_buf_t& line) {
  line.append(text.data(), text.data() + text.size());
}

/// Calls f(name, value) for all that is there, in the order in which they are written; values are text or
/// numbers.
template <class F>
void for_each_field(const std::string& worker, F&& f) {
  static constexpr LogFields kNone;
  const LogFields& fields = fields_of_thread != nullptr ? *fields_of_thread : kNone;
  if (!fields.job.empty()) f("job", fields.job);
  if (fields.unit) f("unit", *fields.unit);
  if (fields.attempt) f("attempt", *fields.attempt);
  if (const std::string_view name = fields.worker.empty() ? worker : fields.worker; !name.empty())
    f("worker", name);
  if (!fields.host.empty()) f("host", fields.host);
  if (!fields.user.empty()) f("user", fields.user);
  if (!fields.peer.empty()) f("peer", fields.peer);
}

void append_value(std::uint32_t value, spdlog::memory_buf_t& line) { append(std::to_string(value), line); }

void append_value(std::string_view value, spdlog::memory_buf_t& line) {
  if (value.find_first_of(" \"=\\") == std::string_view::npos) return append(base::printable(value), line);
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted.push_back('\\');
    quoted.push_back(c);
  }
  append(base::printable(quoted + "\""), line);
}

/// The message and its fields, in a pattern of spdlog's.
class MessageAndFields final : public spdlog::custom_flag_formatter {
 public:
  explicit MessageAndFields(std::string worker) : worker_(std::move(worker)) {}

  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& line) override {
    append(base::printable({message.payload.data(), message.payload.size()}), line);
    for_each_field(worker_, [&](std::string_view name, auto value) {
      line.push_back(' ');
      append(name, line);
      line.push_back('=');
      append_value(value, line);
    });
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<MessageAndFields>(worker_);
  }

 private:
  const std::string worker_;
};

/// RFC 3339, UTC, milliseconds.
std::string time_of(spdlog::log_clock::time_point time) {
  const auto since_epoch = std::chrono::floor<std::chrono::milliseconds>(time.time_since_epoch());
  const auto whole = std::chrono::floor<std::chrono::seconds>(since_epoch);
  const std::time_t seconds = whole.count();
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::string written(20, '\0');
  written.resize(std::strftime(written.data(), written.size(), "%Y-%m-%dT%H:%M:%S", &utc));
  const std::string fraction = std::to_string((since_epoch - whole).count());
  return written + '.' + std::string(3 - fraction.size(), '0') + fraction + 'Z';
}

class JsonFormatter final : public spdlog::formatter {
 public:
  explicit JsonFormatter(std::string worker) : worker_(std::move(worker)) {}

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override {
    const auto text = [](spdlog::string_view_t view) { return std::string(view.data(), view.size()); };
    nlohmann::ordered_json object;
    object["time"] = time_of(message.time);
    object["level"] = text(spdlog::level::to_string_view(message.level));
    object["program"] = text(message.logger_name);
    object["message"] = text(message.payload);
    for_each_field(worker_, [&](const char* name, auto value) { object[name] = value; });
    append(object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace), line);
    line.push_back('\n');
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JsonFormatter>(worker_);
  }

 private:
  const std::string worker_;
};

}  // namespace

LogAbout::LogAbout(const LogFields& fields) : outer_(std::exchange(fields_of_thread, &fields)) {}
LogAbout::~LogAbout() { fields_of_thread = outer_; }

void RecentLines::sink_it_(const spdlog::details::log_msg& message) {
  static constexpr LogFields kNone;
  const LogFields& fields = fields_of_thread != nullptr ? *fields_of_thread : kNone;
  const auto since_epoch = message.time.time_since_epoch();
  const auto level = spdlog::level::to_string_view(message.level);
  lines_.push_back({.number = ++count_,
                    .unix_ms = std::chrono::duration_cast<std::chrono::milliseconds>(since_epoch).count(),
                    .level = {level.data(), level.size()},
                    .is_warning = message.level >= spdlog::level::warn,
                    .message = {message.payload.data(), message.payload.size()},
                    .job = std::string{fields.job},
                    .worker = std::string{fields.worker},
                    .user = std::string{fields.user}});
  if (lines_.size() > kMost) lines_.pop_front();
}

std::vector<LogLine> RecentLines::after(std::uint64_t after) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t news = after >= count_ ? 0 : std::min<std::uint64_t>(count_ - after, lines_.size());
  return {lines_.end() - static_cast<std::ptrdiff_t>(news), lines_.end()};
}

std::vector<std::string> RecentLines::last_about(std::string_view job, std::size_t most_bytes) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> chosen;
  std::size_t left = most_bytes;
  for (auto line = lines_.rbegin(); line != lines_.rend(); ++line) {
    if (line->job.empty() ? !line->is_warning : line->job != job) continue;
    const spdlog::log_clock::time_point time{std::chrono::milliseconds{line->unix_ms}};
    std::string text = time_of(time) + " [" + line->level + "] " + base::printable(line->message);
    // The latest one tells most: what fits of it is kept.
    if (chosen.empty()) text = std::string{base::beginning_of(text, left)};
    if (text.size() > left) break;
    left -= text.size();
    chosen.push_back(std::move(text));
  }
  std::ranges::reverse(chosen);
  return chosen;
}

std::shared_ptr<RecentLines> keep_recent_lines() {
  auto lines = std::make_shared<RecentLines>();
  spdlog::default_logger()->sinks().push_back(lines);
  return lines;
}

std::unique_ptr<spdlog::formatter> make_log_formatter(LogFormat format, std::string worker) {
  if (format == LogFormat::kJson) return std::make_unique<JsonFormatter>(std::move(worker));
  auto text = std::make_unique<spdlog::pattern_formatter>();
  text->add_flag<MessageAndFields>('*', std::move(worker))
      .set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*");
  return text;
}

void set_up_log(const LogOptions& options) {
  const auto logger = spdlog::stderr_color_mt(options.program);
  logger->set_formatter(
      make_log_formatter(options.format == "json" ? LogFormat::kJson : LogFormat::kText, options.worker));
  spdlog::set_default_logger(logger);
  spdlog::set_level(spdlog::level::from_str(options.level));
}

}  // namespace tessera::telemetry
