#include "command/settings_page.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/settings.h"

namespace tessera::client {
namespace {

/// "`sobol`: Owen-scrambled; `independent`: ..." of an enum; bounds of a number.
std::string values_of(const wire::SettingField& setting) {
  using google::protobuf::FieldDescriptor;
  if (const wire::EnumType* const type = setting.field->enum_type(); type != nullptr) {
    const auto with_meaning = [&](std::string* out, const std::string& word) {
      absl::StrAppend(out, "`", word, "`: ", wire::meaning_of(*type, word));
    };
    return absl::StrJoin(wire::words_of(*type), "; ", with_meaning);
  }
  if (setting.field->cpp_type() == FieldDescriptor::CPPTYPE_BOOL) return "`on`, `off`";
  if (setting.name == "integrator") return "[below](#integrators)";
  if (setting.name == "exposure") return "[cameras](cameras.md#exposure)";
  if (setting.field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) return "[colour](colour.md#sensors)";
  const v1::Setting& traits = setting.traits();
  if (!traits.has_least()) return "";
  const std::string least = absl::StrFormat("%s%.15g", traits.or_zero() ? "0 or " : "", traits.least());
  return traits.has_most() ? absl::StrFormat("%s to %.15g", least, traits.most()) : least + " or more";
}

std::string usual_of(const wire::SettingField& setting) {
  if (!setting.traits().usual().empty()) return absl::StrCat("`", setting.traits().usual(), "`");
  if (const wire::EnumType* const type = setting.field->enum_type(); type != nullptr)
    return absl::StrCat("`", wire::words_of(*type).front(), "`");
  return setting.field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_BOOL ? "`off`" : "";
}

}  // namespace

std::string settings_document() {
  std::string text =
      "# Settings\n\n"
      "<!-- Written by `tessera settings --document`, from proto/tessera/v1/settings.proto; a test compares "
      "them. -->\n\n"
      "`render`, `submit`, `estimate` and `bench` take a setting as `--set NAME=VALUE`, or as `--NAME "
      "VALUE`; a scene in\n"
      "Tessera's own format has it in `settings { }`, with underscores for hyphens and the names of "
      "settings.proto for\n"
      "words; Python in `scene.settings`. What the command line says goes before what the scene says. "
      "Settings of one\n"
      "integrator are refused with another; in a scene they wait for a job that has their integrator.\n";
  std::string group = "-";
  for (const wire::SettingField& setting : wire::settings()) {
    const std::string own = setting.group == nullptr ? "" : setting.name.substr(0, setting.name.find('.'));
    if (own != group) {
      absl::StrAppend(&text, "\n## ",
                      own.empty() ? "All integrators" : absl::StrCat("Integrator `", own, "`"),
                      "\n\n| setting | what it is | values | usually |\n|---|---|---|---|\n");
      group = own;
    }
    absl::StrAppend(&text, "| `", setting.name, "` | ", setting.traits().about(), " | ", values_of(setting),
                    " | ", usual_of(setting), " |\n");
  }
  text += "\n## Integrators\n\n| integrator | what it is |\n|---|---|\n";
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms())
    absl::StrAppend(&text, "| `", algorithm.name, "` | ", wire::description_of(algorithm), " |\n");
  return text + "| `auto` | the best of path, bdpt, vcm and light, by a short pilot (command-line.md) |\n";
}

}  // namespace tessera::client
