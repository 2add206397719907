#include "command/setup/config_file.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "base/nearest_name.h"

// Version 3.3 asserts that keys begin as keys do, and has an error for those that do not in its next lines.
#define TOML_ASSERT(expression) static_cast<void>(0)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

namespace tessera::client {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
constexpr const char* kDefaults = "defaults";
const std::vector<std::string> kPlainKeys = {"server", "tls", "allow-insecure"};

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// "~/x" in the user's home: what a shell would do.
std::string without_tilde(const std::string& path) {
  return path.starts_with("~/") && !variable("HOME").empty() ? variable("HOME") + path.substr(1) : path;
}

/// Text of a value, as a command line has it; none for what cannot be one.
std::optional<std::string> text_of(const toml::node& node) {
  if (const auto text = node.value_exact<std::string>()) return *text;
  if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
  if (const auto whole = node.value_exact<std::int64_t>()) return absl::StrCat(*whole);
  if (const auto real = node.value_exact<double>()) return absl::StrCat(*real);
  const toml::array* const list = node.as_array();
  if (list == nullptr) return std::nullopt;
  std::vector<std::string> elements;
  for (const toml::node& element : *list) {
    const std::optional<std::string> text = element.is_array() ? std::nullopt : text_of(element);
    if (!text) return std::nullopt;
    elements.push_back(*text);
  }
  return absl::StrJoin(elements, ",");
}

/// Collects the settings of one file.
class Settings {
 public:
  explicit Settings(const std::string& path) : path_(path) {}

  absl::Status add_all(const toml::table& root) {
    for (const auto& [key, node] : root) {
      const std::string name{key.str()};
      if (const toml::table* const table = node.as_table()) {
        for (const auto& [inner, value] : *table) {
          const std::string option{inner.str()};
          if (absl::Status status = add(absl::StrCat(name, ".", option), value); !status.ok()) return status;
        }
        continue;
      }
      if (std::ranges::find(kPlainKeys, name) == kPlainKeys.end()) {
        return fault(node,
                     absl::StrCat("there is no setting '", name, "'", base::did_you_mean(name, kPlainKeys),
                                  "; options of commands are in a table: [defaults] or [COMMAND]"));
      }
      if (absl::Status status = add(name, node); !status.ok()) return status;
    }
    return absl::OkStatus();
  }
  std::vector<ConfigValue> take() { return std::move(values_); }

 private:
  std::string place(const toml::node& node) const {
    return absl::StrCat(path_, ":", node.source().begin.line);
  }
  absl::Status fault(const toml::node& node, const std::string& what) const {
    return absl::InvalidArgumentError(absl::StrCat(place(node), ": ", what));
  }
  absl::Status add(const std::string& key, const toml::node& node) {
    const std::optional<std::string> text = text_of(node);
    if (!text)
      return fault(node, absl::StrCat(key, ": a text, a number, true, false, or a list was expected"));
    const bool is_path = key == "tls" || key.ends_with(".tls");
    values_.push_back({key, is_path ? without_tilde(*text) : *text, place(node)});
    return absl::OkStatus();
  }

  std::string path_;
  std::vector<ConfigValue> values_;
};

/// A value as TOML has it: numbers, booleans and lists as they are, anything else as a text.
std::string as_toml(const std::string& value) {
  const toml::parse_result parsed = toml::parse(absl::StrCat("value = ", value));
  if (parsed && parsed.table().size() == 1) {
    const toml::node* const node = parsed.table().get("value");
    if (node != nullptr && (node->is_boolean() || node->is_number() || node->is_array())) return value;
  }
  return absl::StrCat("\"", absl::StrReplaceAll(value, {{"\\", "\\\\"}, {"\"", "\\\""}}), "\"");
}

bool is_name(std::string_view name) {
  return !name.empty() &&
         std::ranges::all_of(name, [](char c) { return absl::ascii_isalpha(c) || c == '-'; });
}

/// Whether a line sets `name`.
bool sets(absl::string_view row, const std::string& name) {
  row = absl::StripAsciiWhitespace(row);
  return absl::ConsumePrefix(&row, name) && absl::StartsWith(absl::StripLeadingAsciiWhitespace(row), "=");
}

/// Whether a comment shows how `name` is set.
bool shows(absl::string_view row, const std::string& name) {
  row = absl::StripLeadingAsciiWhitespace(row);
  return absl::ConsumePrefix(&row, "#") && sets(row, name);
}

bool is_header(absl::string_view row) {
  return absl::StartsWith(absl::StripLeadingAsciiWhitespace(row), "[");
}

}  // namespace

std::string config_path() {
  if (const std::string named = variable("TESSERA_CONFIG"); !named.empty()) return named;
  if (const std::string folder = variable("XDG_CONFIG_HOME"); !folder.empty())
    return folder + "/tessera/config.toml";
  const std::string home = variable("HOME");
  return home.empty() ? "" : home + "/.config/tessera/config.toml";
}

absl::StatusOr<std::vector<ConfigValue>> parse_config(const std::string& text, const std::string& path) {
  const toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    const toml::parse_error& error = parsed.error();
    return absl::InvalidArgumentError(
        absl::StrCat(path, ":", error.source().begin.line, ": ", std::string{error.description()}));
  }
  Settings settings(path);
  if (absl::Status status = settings.add_all(parsed.table()); !status.ok()) return status;
  return settings.take();
}

absl::StatusOr<std::vector<ConfigValue>> read_config(const std::string& path) {
  std::error_code error;
  if (path.empty() || !std::filesystem::exists(path, error)) return std::vector<ConfigValue>{};
  std::ifstream in(path, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in.is_open() || in.bad()) return absl::InvalidArgumentError(absl::StrCat(path, " cannot be read"));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxBytes)
    return absl::InvalidArgumentError(absl::StrCat(path, ": more than ", kMaxBytes, " bytes"));
  return parse_config(text, path);
}

std::vector<options::FileValue> values_for(const std::string& command,
                                           const std::vector<ConfigValue>& config) {
  // The last one counts.
  std::vector<options::FileValue> general, own;
  for (const ConfigValue& value : config) {
    const std::size_t dot = value.key.find('.');
    const std::string table = dot == std::string::npos ? kDefaults : value.key.substr(0, dot);
    const std::string option = "--" + value.key.substr(dot == std::string::npos ? 0 : dot + 1);
    if (table == kDefaults) general.push_back({option, value.text, value.place, false});
    if (table == command) own.push_back({option, value.text, value.place, true});
  }
  general.insert(general.end(), own.begin(), own.end());
  return general;
}

absl::StatusOr<std::string> with_setting(const std::string& text, const std::string& key,
                                         const std::string& value) {
  const std::size_t dot = key.find('.');
  const std::string table = dot == std::string::npos ? "" : key.substr(0, dot);
  const std::string name = key.substr(dot == std::string::npos ? 0 : dot + 1);
  if (!is_name(name) || (dot != std::string::npos && !is_name(table))) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", key, "' is no key; expected server, tls, defaults.OPTION or COMMAND.OPTION"));
  }
  const std::string line = absl::StrCat(name, " = ", as_toml(value));
  std::vector<std::string> lines = absl::StrSplit(text, '\n');
  if (!lines.empty() && lines.back().empty()) lines.pop_back();
  // The lines of the table: [begin, end).
  const std::string header = absl::StrCat("[", table, "]");
  auto begin = lines.begin();
  if (!table.empty()) {
    begin = std::ranges::find_if(lines, [&](const std::string& row) { return row.starts_with(header); });
    if (begin != lines.end())
      ++begin;
    else
      lines.insert(lines.end(), {header, line}), begin = lines.end();
  }
  if (begin != lines.end() || table.empty()) {
    const auto end = std::find_if(begin, lines.end(), is_header);
    const auto old = std::find_if(begin, end, [&](const std::string& row) { return sets(row, name); });
    if (old != end) {
      *old = line;
    } else {  // below an example of it, where there is one
      const auto example = std::find_if(begin, end, [&](const std::string& row) { return shows(row, name); });
      lines.insert(example != end ? example + 1 : end, line);
    }
  }
  const std::string result = absl::StrCat(absl::StrJoin(lines, "\n"), "\n");
  if (const auto parsed = parse_config(result, "the file"); !parsed.ok()) return parsed.status();
  return result;
}

}  // namespace tessera::client
