#include "command/setting_options.h"

#include <array>
#include <vector>

#include "absl/strings/str_cat.h"
#include "command/jobs/auto_choice.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/settings.h"

namespace tessera::client {
namespace {

std::string check_integrator(const std::string& name) {
  if (name == kAutoIntegrator || wire::find_algorithm(name) != nullptr) return "";
  return wire::why_no_algorithm(name, std::array{kAutoIntegrator});
}

std::vector<options::Choice> integrators() {
  std::vector<options::Choice> choices;
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms())
    choices.push_back({algorithm.name, wire::description_of(algorithm)});
  choices.push_back({kAutoIntegrator, "the best of path, bdpt, vcm and light, by a short pilot"});
  return choices;
}

std::vector<options::Choice> choices_of(const wire::EnumType& type) {
  std::vector<options::Choice> choices;
  for (const std::string& word : wire::words_of(type))
    choices.push_back({word, wire::meaning_of(type, word)});
  return choices;
}

void define(options::Command& command, const wire::SettingField& setting, v1::RenderSettings& settings) {
  using google::protobuf::FieldDescriptor;
  const v1::Setting& traits = setting.traits();
  const auto type = setting.field->cpp_type();
  const bool is_flag = type == FieldDescriptor::CPPTYPE_BOOL && traits.value().empty();
  const bool is_word = type == FieldDescriptor::CPPTYPE_ENUM || type == FieldDescriptor::CPPTYPE_STRING;
  const auto take = [&setting, &settings, is_flag](const std::string& text) {
    return wire::set_setting(setting, is_flag && text.empty() ? "on" : text, settings);
  };
  // The help has the first half sentence about words of a language of their own; `tessera settings NAME` has
  // all.
  const std::size_t colon =
      type == FieldDescriptor::CPPTYPE_STRING ? traits.about().find(':') : std::string::npos;
  const bool is_cut = traits.option() && colon != std::string::npos;
  const std::string about = is_cut ? traits.about().substr(0, colon) : traits.about();
  options::Option option = command.add_read_by(absl::StrCat("--", setting.name).c_str(), take, about.c_str());
  option.type_name(!traits.value().empty()                   ? traits.value().c_str()
                   : is_word                                 ? "NAME"
                   : type == FieldDescriptor::CPPTYPE_DOUBLE ? "X"
                                                             : "N");
  if (is_flag) option.as_flag();
  if (!traits.usual().empty() && !is_cut) option.with_default(traits.usual().c_str());
  if (traits.has_most()) option.in_range(traits.least(), traits.most());
  if (type == FieldDescriptor::CPPTYPE_ENUM) {
    const std::vector<options::Choice> choices = choices_of(*setting.field->enum_type());
    option.listing(choices).with_default(choices.front().name.c_str());
  }
  if (setting.name == "integrator") option.listing(integrators()).checked_by(check_integrator);
  if (!traits.option()) option.as_setting();
  if (!traits.former().empty()) option.formerly(traits.former());
}

}  // namespace

void define_settings(options::Command& command, v1::RenderSettings& settings,
                     const std::function<bool(const std::string& name)>& wanted) {
  for (const wire::SettingField& setting : wire::settings()) {
    if (!wanted(setting.name)) continue;
    const std::size_t period = setting.name.find('.');
    const std::string group =
        period == std::string::npos ? "Quality" : absl::StrCat("Integrator ", setting.name.substr(0, period));
    command.group(group.c_str());
    define(command, setting, settings);
  }
  command.group("Quality");
  command.add_set("any other setting: tessera settings tells of them");
}

}  // namespace tessera::client
