// Options and commands while they are being defined.
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "options/program.h"
#include "options/spec.h"

namespace tessera::options {
namespace {

std::string text_of(double number) { return absl::StrFormat("%.15g", number); }

/// "a whole number from 1 to 1024".
std::string expectation(const char* kind, const OptionSpec& spec) {
  if (!spec.range) return kind;
  return absl::StrCat(kind, " from ", text_of(spec.range->first), " to ", text_of(spec.range->second));
}

template <class T>
absl::Status read_number(const OptionSpec& spec, const std::string& text, T& value) {
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  bool sound = error == std::errc{} && end == text.data() + text.size() && !text.empty();
  if constexpr (std::is_floating_point_v<T>) sound = sound && std::isfinite(number);
  if (sound && spec.range) {
    const auto given = static_cast<double>(number);
    sound = given >= spec.range->first && given <= spec.range->second;
  }
  if (!sound) {
    const char* const kind = std::is_floating_point_v<T> ? "a number"
                             : std::is_signed_v<T>       ? "a whole number"
                                                         : "a whole number without a sign";
    return absl::InvalidArgumentError(absl::StrCat(
        "expected ", expectation(spec.range && std::is_integral_v<T> ? "a whole number" : kind, spec),
        ", not '", text, "'"));
  }
  value = number;
  return absl::OkStatus();
}

OptionSpec& add_spec(CommandSpec& command, const char* name, const char* description,
                     const char* value_name) {
  OptionSpec& spec = *command.options.emplace_back(std::make_unique<OptionSpec>());
  spec.names = absl::StrSplit(name, ',');
  spec.description = description;
  spec.value_name = value_name;
  spec.group = command.current_group;
  return spec;
}

template <class T>
Option add_number(CommandSpec& command, const char* name, T& value, const char* description) {
  OptionSpec& spec = add_spec(command, name, description, std::is_floating_point_v<T> ? "X" : "N");
  spec.take = [&spec, &value](const std::string& text) { return read_number(spec, text, value); };
  spec.show = [&value] { return absl::StrCat(value); };
  return Option{spec};
}

template <class T>
Option add_optional(CommandSpec& command, const char* name, std::optional<T>& value,
                    const char* description) {
  OptionSpec& spec = add_spec(command, name, description, std::is_floating_point_v<T> ? "X" : "N");
  spec.take = [&spec, &value](const std::string& text) {
    T number{};
    absl::Status status = read_number(spec, text, number);
    if (status.ok()) value = number;
    return status;
  };
  return Option{spec};
}

template <class T>
OptionSpec& add_list(CommandSpec& command, const char* name, std::vector<T>& value, const char* description,
                     const char* value_name) {
  OptionSpec& spec = add_spec(command, name, description, value_name);
  spec.list = true;
  spec.clear = [&value] { value.clear(); };
  spec.show = [&value] { return absl::StrJoin(value, ","); };
  return spec;
}

}  // namespace

Option Option::required() {
  spec_->required = true;
  return *this;
}

Option Option::with_default() {
  spec_->shown_default = spec_->show();
  return *this;
}

Option Option::with_default(const char* meaning) {
  spec_->shown_default = meaning;
  return *this;
}

Option Option::type_name(const char* name) {
  spec_->value_name = name;
  return *this;
}

Option Option::in_range(double least, double most) {
  spec_->range = {least, most};
  return *this;
}

Option Option::one_of(std::vector<std::string> names) {
  spec_->choices = std::move(names);
  return *this;
}

Option Option::completing(std::vector<std::string> words) {
  spec_->completions = std::move(words);
  return *this;
}

Option Option::listing(std::vector<Choice> choices) {
  spec_->listed_choices = std::move(choices);
  return *this;
}

Option Option::separated_by_commas() {
  spec_->commas = true;
  return *this;
}

Option Option::from_environment(const char* variable) {
  spec_->environment = variable;
  return *this;
}

Option Option::excludes(const Option& other) {
  spec_->excludes.push_back(other.spec_);
  return *this;
}

Option Option::needs(const Option& other) {
  spec_->needs.push_back(other.spec_);
  return *this;
}

Option Option::as_flag() {
  spec_->value_name.clear();
  return *this;
}

Option Option::as_setting() {
  spec_->hidden = true;
  return *this;
}

Option Option::formerly(std::string name) {
  spec_->former.push_back(std::move(name));
  return *this;
}

Option Option::checked_by(std::function<std::string(const std::string&)> check) {
  spec_->checks.push_back(std::move(check));
  return *this;
}

void Command::group(const char* heading) { spec_->current_group = heading; }

Command& Command::example(const char* line) {
  spec_->examples.emplace_back(line);
  return *this;
}

Option Command::add(const char* name, std::string& value, const char* description) {
  OptionSpec& spec = add_spec(*spec_, name, description, "TEXT");
  spec.take = [&value](const std::string& text) {
    value = text;
    return absl::OkStatus();
  };
  spec.show = [&value] { return value; };
  return Option{spec};
}

Option Command::add(const char* name, std::int32_t& value, const char* description) {
  return add_number(*spec_, name, value, description);
}

Option Command::add(const char* name, std::uint32_t& value, const char* description) {
  return add_number(*spec_, name, value, description);
}

Option Command::add(const char* name, std::uint64_t& value, const char* description) {
  return add_number(*spec_, name, value, description);
}

Option Command::add(const char* name, double& value, const char* description) {
  return add_number(*spec_, name, value, description);
}

Option Command::add(const char* name, std::optional<std::uint32_t>& value, const char* description) {
  return add_optional(*spec_, name, value, description);
}

Option Command::add(const char* name, std::optional<double>& value, const char* description) {
  return add_optional(*spec_, name, value, description);
}

Option Command::add(const char* name, std::vector<std::uint32_t>& value, const char* description) {
  OptionSpec& spec = add_list(*spec_, name, value, description, "N,...");
  spec.take = [&spec, &value](const std::string& text) {
    std::uint32_t number = 0;
    absl::Status status = read_number(spec, text, number);
    if (status.ok()) value.push_back(number);
    return status;
  };
  return Option{spec};
}

Option Command::add(const char* name, std::vector<std::string>& value, const char* description) {
  OptionSpec& spec = add_list(*spec_, name, value, description, "TEXT");
  spec.take = [&value](const std::string& text) {
    value.push_back(text);
    return absl::OkStatus();
  };
  return Option{spec};
}

Option Command::add_read_by(const char* name, std::function<absl::Status(const std::string&)> take,
                            const char* description) {
  OptionSpec& spec = add_spec(*spec_, name, description, "TEXT");
  spec.take = std::move(take);
  return Option{spec};
}

Option Command::add_list_read_by(const char* name, std::function<absl::Status(const std::string&)> take,
                                 std::function<void()> clear, const char* description) {
  OptionSpec& spec = add_spec(*spec_, name, description, "TEXT");
  spec.list = true;
  spec.take = std::move(take);
  spec.clear = std::move(clear);
  return Option{spec};
}

Option Command::add_flag(const char* name, bool& value, const char* description) {
  OptionSpec& spec = add_spec(*spec_, name, description, "");
  spec.take = [&value](const std::string& text) {
    value = text != "off";
    return absl::OkStatus();
  };
  return Option{spec};
}

Option Command::add_set(const char* description) {
  OptionSpec& spec = add_spec(*spec_, "--set", description, "NAME=VALUE");
  spec.list = spec.sets = true;
  return Option{spec};
}

Option Command::option(const char* name) { return Option{*spec_->find(name)}; }

std::vector<std::string> Command::given(const std::vector<std::string>& but_for) const {
  std::vector<std::string> words;
  for (const auto& option : spec_->options) {
    const bool left_out =
        std::ranges::any_of(but_for, [&](const std::string& name) { return option->is_called(name); });
    if (option->is_argument() || option->sets || left_out) continue;
    for (const std::string& value : option->given)
      words.push_back(absl::StrCat(option->name(), value.empty() ? "" : "=", value));
  }
  return words;
}

void Command::runs(std::function<int()> action) { spec_->action = std::move(action); }

}  // namespace tessera::options
