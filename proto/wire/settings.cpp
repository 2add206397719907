#include "wire/settings.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "wire/enum_words.h"

namespace tessera::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

const v1::Setting& traits_of(const FieldDescriptor& field) {
  return field.options().GetExtension(v1::setting);
}

bool is_message(const FieldDescriptor& field) { return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE; }
bool is_enum(const FieldDescriptor& field) { return field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM; }

std::string with_hyphens(std::string name) {
  std::ranges::replace(name, '_', '-');
  return name;
}

std::vector<const FieldDescriptor*> fields_of(const Descriptor& type) {
  std::vector<const FieldDescriptor*> fields;
  for (int i = 0; i < type.field_count(); ++i) {
    if (!type.field(i)->is_repeated()) fields.push_back(type.field(i));
  }
  return fields;
}

std::vector<SettingField> list_settings() {
  std::vector<SettingField> all;
  for (const FieldDescriptor* const field : fields_of(*v1::RenderSettings::descriptor())) {
    const std::string name = with_hyphens(field->name());
    if (!is_message(*field)) {
      all.push_back({name, nullptr, field});
      continue;
    }
    for (const FieldDescriptor* const own : fields_of(*field->message_type()))
      all.push_back({absl::StrCat(name, ".", with_hyphens(own->name())), field, own});
  }
  return all;
}

std::string text_of(double number) { return absl::StrFormat("%.15g", number); }

/// "1 to 4096", "0 or 2 to 12"; empty without bounds.
std::string bounds_of(const v1::Setting& traits) {
  if (!traits.has_least()) return "";
  const std::string least = absl::StrCat(traits.or_zero() ? "0 or " : "", text_of(traits.least()));
  return traits.has_most() ? absl::StrCat(least, " to ", text_of(traits.most()))
                           : absl::StrCat(least, " or more");
}

bool is_within(double value, const v1::Setting& traits) {
  if (value == 0 && traits.or_zero()) return true;
  return !(traits.has_least() && !(value >= traits.least())) &&
         !(traits.has_most() && !(value <= traits.most()));
}

template <class Number>
absl::StatusOr<Number> parse_number(const std::string& text, const v1::Setting& traits) {
  if (traits.value() == "SIZE") {
    if constexpr (std::is_same_v<Number, std::uint64_t>) return parse_bytes(text);
  }
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  bool sound = error == std::errc{} && end == text.data() + text.size() &&
               is_within(static_cast<double>(number), traits);
  if constexpr (std::is_floating_point_v<Number>) sound = sound && std::isfinite(number);
  if (sound) return number;
  std::string bounds = bounds_of(traits);
  if (bounds.empty() && std::is_integral_v<Number>)
    bounds = absl::StrCat("0 to ", std::numeric_limits<Number>::max());
  return absl::InvalidArgumentError(absl::StrCat("expected ",
                                                 std::is_integral_v<Number> ? "a whole number" : "a number",
                                                 bounds.empty() ? "" : ", ", bounds, ", not '", text, "'"));
}

absl::StatusOr<bool> parse_switch(const std::string& text) {
  if (text == "on" || text == "true") return true;
  if (text == "off" || text == "false") return false;
  return absl::InvalidArgumentError(absl::StrCat("expected on or off, not '", text, "'"));
}

absl::Status set_field(const FieldDescriptor& field, const std::string& text, Message& message) {
  const Reflection& reflection = *message.GetReflection();
  const auto set = [&](const auto& parsed, auto setter) {
    if (parsed.ok()) (reflection.*setter)(&message, &field, *parsed);
    return parsed.status();
  };
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return set(parse_number<double>(text, traits_of(field)), &Reflection::SetDouble);
    case FieldDescriptor::CPPTYPE_UINT32:
      return set(parse_number<std::uint32_t>(text, traits_of(field)), &Reflection::SetUInt32);
    case FieldDescriptor::CPPTYPE_UINT64:
      return set(parse_number<std::uint64_t>(text, traits_of(field)), &Reflection::SetUInt64);
    case FieldDescriptor::CPPTYPE_BOOL:
      return set(parse_switch(text), &Reflection::SetBool);
    case FieldDescriptor::CPPTYPE_ENUM:
      return set(number_of(*field.enum_type(), text, wire::name_of(*field.enum_type())),
                 &Reflection::SetEnumValue);
    case FieldDescriptor::CPPTYPE_STRING:
      reflection.SetString(&message, &field, text);
      return absl::OkStatus();
    default:
      return absl::UnimplementedError(absl::StrCat(field.full_name(), " has a type that no setting has"));
  }
}

bool is_number(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE ||
         field.cpp_type() == FieldDescriptor::CPPTYPE_UINT32 ||
         field.cpp_type() == FieldDescriptor::CPPTYPE_UINT64;
}

absl::Status check_value(const Message& message, const FieldDescriptor& field, const v1::Setting& traits,
                         const std::string& name) {
  const bool is_there = message.GetReflection()->HasField(message, &field);
  if (!is_number(field) || !is_there) return absl::OkStatus();
  const double value = number_in(message, field);
  if (is_within(value, traits)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", text_of(value), "; ", bounds_of(traits), " was expected"));
}

/// The settings of one algorithm.
absl::Status check_own_values(const Message& own, const std::string& group) {
  for (const FieldDescriptor* const field : fields_of(*own.GetDescriptor())) {
    const std::string name = absl::StrCat(group, ".", with_hyphens(field->name()));
    if (!traits_of(*field).usual().empty() && !own.GetReflection()->HasField(own, field))
      return absl::InvalidArgumentError(absl::StrCat("the job does not say what ", name, " is"));
    v1::Setting traits = traits_of(*field);
    if (const FieldDescriptor* const lower = own.GetDescriptor()->FindFieldByName(traits.not_below());
        lower != nullptr)
      traits.set_least(std::max(traits.least(), number_in(own, *lower)));
    if (absl::Status status = check_value(own, *field, traits, name); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

const v1::Setting& SettingField::traits() const { return traits_of(*field); }

const std::vector<SettingField>& settings() {
  static const std::vector<SettingField> all = list_settings();
  return all;
}

absl::Status set_setting(const SettingField& setting, const std::string& text, v1::RenderSettings& settings) {
  Message* const message = setting.group == nullptr
                               ? &settings
                               : settings.GetReflection()->MutableMessage(&settings, setting.group);
  return set_field(*setting.field, text, *message);
}

absl::StatusOr<std::uint64_t> parse_bytes(const std::string& text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string unit =
      error == std::errc{} ? text.substr(static_cast<std::size_t>(end - text.data())) : "?";
  constexpr std::string_view kUnits = "KMGT";
  const std::size_t power = unit.size() == 1 ? kUnits.find(unit.front()) : std::string_view::npos;
  const int shift = power == std::string_view::npos ? 0 : 10 * (static_cast<int>(power) + 1);
  if ((unit.empty() || shift > 0) && number > 0 && number <= UINT64_MAX >> shift) return number << shift;
  return absl::InvalidArgumentError("expected bytes, or K, M, G or T of them, as in 512M");
}

void fill_in_usual(Message& message) {
  for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor())) {
    if (is_message(*field) || message.GetReflection()->HasField(message, field)) continue;
    if (is_enum(*field)) {
      message.GetReflection()->SetEnumValue(&message, field, 1);
    } else if (const std::string& usual = traits_of(*field).usual(); !usual.empty()) {
      set_field(*field, usual, message).IgnoreError();  // settings_test sets them all
    }
  }
}

double number_in(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_UINT32:
      return reflection.GetUInt32(message, &field);
    case FieldDescriptor::CPPTYPE_UINT64:
      return static_cast<double>(reflection.GetUInt64(message, &field));
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection.GetBool(message, &field) ? 1 : 0;
    case FieldDescriptor::CPPTYPE_ENUM:
      return reflection.GetEnumValue(message, &field);
    default:
      return 0;
  }
}

const FieldDescriptor* own_settings(const Descriptor& type, const std::string& integrator) {
  std::string name = integrator;
  std::ranges::replace(name, '-', '_');
  const FieldDescriptor* const field = type.FindFieldByName(name);
  return field != nullptr && is_message(*field) && !field->is_repeated() ? field : nullptr;
}

absl::Status check_owner(const Message& message, const std::string& integrator) {
  const FieldDescriptor* const own = own_settings(*message.GetDescriptor(), integrator);
  for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor())) {
    if (!is_message(*field) || field == own || !message.GetReflection()->HasField(message, field)) continue;
    const std::string name = with_hyphens(field->name());
    return absl::InvalidArgumentError(absl::StrCat("integrator '", integrator, "' has no settings '", name,
                                                   "', which are for '", name, "'"));
  }
  return absl::OkStatus();
}

double within_bounds(std::string_view name, double value) {
  const auto setting = std::ranges::find(settings(), name, &SettingField::name);
  const v1::Setting& traits = setting->traits();
  return std::clamp(value, traits.least(), traits.has_most() ? traits.most() : HUGE_VAL);
}

absl::Status check_values(const Message& part) {
  for (const FieldDescriptor* const field : fields_of(*part.GetDescriptor())) {
    const FieldDescriptor* const setting = v1::RenderSettings::descriptor()->FindFieldByName(field->name());
    if (setting == nullptr || setting->is_repeated()) continue;
    const std::string name = with_hyphens(field->name());
    if (!is_message(*field)) {
      if (absl::Status s = check_value(part, *field, traits_of(*setting), name); !s.ok()) return s;
    } else if (part.GetReflection()->HasField(part, field)) {
      if (absl::Status s = check_own_values(part.GetReflection()->GetMessage(part, field), name); !s.ok())
        return s;
    }
  }
  return absl::OkStatus();
}

}  // namespace tessera::wire
