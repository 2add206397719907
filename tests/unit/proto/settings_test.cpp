// The settings of settings.proto, found by reflection: this is all that a new one has to pass.
#include "wire/settings.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "absl/strings/str_format.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/job_check.h"
#include "wire/resolve_settings.h"

namespace tessera::wire {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const SettingField& setting(const std::string& name) {
  return *std::ranges::find(settings(), name, &SettingField::name);
}

absl::Status set(const std::string& name, const std::string& text, v1::RenderSettings& to) {
  return set_setting(setting(name), text, to);
}

std::string refusal(const std::string& name, const std::string& text) {
  v1::RenderSettings into;
  return std::string(set(name, text, into).message());
}

/// A value that is not the usual one, as people write it; empty where the setting has none.
std::string another_value(const SettingField& setting) {
  switch (setting.field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return words_of(*setting.field->enum_type()).back();
    case FieldDescriptor::CPPTYPE_BOOL:
      return "on";
    case FieldDescriptor::CPPTYPE_STRING:
      return "";
    default:
      return setting.traits().has_most() ? absl::StrFormat("%.15g", setting.traits().most()) : "17";
  }
}

/// The part of the job that has the setting; null where none has.
const Message* part_with(const v1::JobSpec& job, const SettingField& setting) {
  const v1::Algorithms& algorithms = job.content().algorithms();
  if (setting.group != nullptr) {
    const FieldDescriptor* const own = algorithms.GetDescriptor()->FindFieldByName(setting.group->name());
    return own == nullptr ? nullptr : &algorithms.GetReflection()->GetMessage(algorithms, own);
  }
  for (const Message* part :
       std::initializer_list<const Message*>{&algorithms, &job.view(), &job.samples()}) {
    if (part->GetDescriptor()->FindFieldByName(setting.field->name()) != nullptr) return part;
  }
  return nullptr;
}

std::string text_in(const Message& part, const std::string& field) {
  std::string text;
  google::protobuf::TextFormat::PrintFieldValueToString(part, part.GetDescriptor()->FindFieldByName(field),
                                                        -1, &text);
  return text;
}

TEST(Settings, EachSaysWhatItIsAndItsUsualValueIsOneOfItsOwn) {
  EXPECT_GT(settings().size(), 40u);
  for (const SettingField& each : settings()) {
    EXPECT_THAT(each.traits().about(), Not(IsEmpty())) << each.name;
    EXPECT_THAT(each.traits().about(), Not(testing::EndsWith("."))) << each.name;
    v1::RenderSettings into;
    if (!each.traits().usual().empty())
      EXPECT_EQ(set_setting(each, each.traits().usual(), into), absl::OkStatus()) << each.name;
    if (each.field->enum_type() == nullptr) continue;
    EXPECT_TRUE(each.traits().usual().empty()) << each.name << ": an enum's first value";
    for (const std::string& word : words_of(*each.field->enum_type()))
      EXPECT_THAT(meaning_of(*each.field->enum_type(), word), Not(IsEmpty())) << each.name << ' ' << word;
  }
}

/// `--set NAME=VALUE` reaches the job, whatever the setting is: nothing in between knows it.
TEST(Settings, EachReachesTheJobAndIsCheckedThere) {
  for (const SettingField& each : settings()) {
    const std::string value = another_value(each);
    if (value.empty()) continue;
    v1::RenderSettings asked;
    const std::string integrator = each.name.substr(0, each.name.find('.'));
    if (each.group != nullptr) asked.set_integrator(integrator);
    ASSERT_EQ(set_setting(each, value, asked), absl::OkStatus()) << each.name;
    v1::JobSpec job, usual;
    resolve_settings(asked, job);
    const Message* const part = part_with(job, each);
    ASSERT_NE(part, nullptr) << each.name;
    const Message& set = each.group == nullptr ? static_cast<const Message&>(asked)
                                               : asked.GetReflection()->GetMessage(asked, each.group);
    EXPECT_EQ(text_in(*part, each.field->name()), text_in(set, each.field->name())) << each.name;
    if (each.field->cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE || !each.traits().has_most()) continue;
    Message& changed = const_cast<Message&>(*part);  // a part of `job`
    changed.GetReflection()->SetDouble(&changed, changed.GetDescriptor()->FindFieldByName(each.field->name()),
                                       2 * each.traits().most());
    add_phases(job);
    EXPECT_THAT(std::string(check_settings(job).message()), HasSubstr(each.name + " is ")) << each.name;
  }
}

TEST(Settings, TextsBecomeNumbersWordsSwitchesAndBytes) {
  v1::RenderSettings into;
  EXPECT_TRUE(set("mlt.step", "0.25", into).ok());
  EXPECT_TRUE(set("photon.photons", "1000", into).ok());
  EXPECT_TRUE(set("path-sharing", "8", into).ok());
  EXPECT_TRUE(set("radiosity.final-gather", "off", into).ok());
  EXPECT_TRUE(set("radiosity.memory-limit", "2G", into).ok());
  EXPECT_TRUE(set("irradiance-cache.glossy-bands", "0", into).ok());
  EXPECT_TRUE(set("seed", "18446744073709551615", into).ok());
  EXPECT_EQ(into.mlt().step(), 0.25);
  EXPECT_EQ(into.photon().photons(), 1000u);
  EXPECT_EQ(into.path_sharing(), v1::PATH_SHARING_8);
  EXPECT_TRUE(into.radiosity().has_final_gather());
  EXPECT_FALSE(into.radiosity().final_gather()) << "over a scene's `true`";
  EXPECT_EQ(into.radiosity().memory_limit(), std::uint64_t{2} << 30);
  EXPECT_TRUE(into.irradiance_cache().has_glossy_bands());
  EXPECT_EQ(into.seed(), ~std::uint64_t{0});
}

TEST(Settings, TextsThatAreNoValueAreRefusedWithWhatWasExpected) {
  for (const char* wrong : {"", "x", "0.6", "-0.1", "nan", "inf", "0.25 ", " 0.25", "0,25"})
    EXPECT_THAT(refusal("mlt.step", wrong), HasSubstr("expected a number, 1e-06 to 0.5, not '")) << wrong;
  for (const char* wrong : {"", "-1", "+1", "1e3", "nan", "18446744073709551616", " 1", "1 "})
    EXPECT_THAT(refusal("seed", wrong), HasSubstr("expected a whole number, 0 to 18446744073709551615"))
        << wrong;
  EXPECT_THAT(refusal("irradiance-cache.glossy-bands", "1"), HasSubstr("0 or 2 to 12"));
  EXPECT_THAT(refusal("radiosity.final-gather", "maybe"), HasSubstr("expected on or off, not 'maybe'"));
  EXPECT_THAT(refusal("radiosity.memory-limit", "4X"), HasSubstr("as in 512M"));
  EXPECT_THAT(refusal("sampler", "sobel"), HasSubstr("did you mean 'sobol'"));
}

TEST(Settings, SettingsOfOneAlgorithmAreNoOthers) {
  v1::RenderSettings photons;
  photons.mutable_photon()->set_radius(1);
  EXPECT_EQ(check_owner(photons, "photon"), absl::OkStatus());
  EXPECT_THAT(std::string(check_owner(photons, "path").message()),
              HasSubstr("integrator 'path' has no settings 'photon', which are for 'photon'"));
  // Every message in RenderSettings is some algorithm's.
  for (const SettingField& each : settings()) {
    if (each.group == nullptr) continue;
    EXPECT_NE(find_algorithm(each.name.substr(0, each.name.find('.'))), nullptr) << each.name;
  }
}

TEST(Settings, AJobWithoutAValueThatItsAlgorithmNeedsIsRefused) {
  v1::JobSpec job;
  v1::RenderSettings asked;
  asked.set_integrator("mlt");
  resolve_settings(asked, job);
  EXPECT_EQ(check_settings(job), absl::OkStatus());
  job.mutable_content()->mutable_algorithms()->mutable_mlt()->clear_mutations();
  EXPECT_THAT(std::string(check_settings(job).message()), HasSubstr("does not say what mlt.mutations is"));
}

TEST(Settings, ForeignNumbersAreBroughtWithinTheBounds) {
  EXPECT_EQ(within_bounds("mlt.step", 7), 0.5);
  EXPECT_EQ(within_bounds("mlt.step", 0.125), 0.125);
  EXPECT_EQ(within_bounds("photon.radius", 1e30), 1e15);
}

}  // namespace
}  // namespace tessera::wire
