#include "wire/scene_numbers.h"

#include <cmath>
#include <type_traits>

#include "absl/strings/str_cat.h"
#include "google/protobuf/message.h"
#include "google/protobuf/reflection.h"

namespace tessera::wire {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// Name of an element; empty for messages that have none.
std::string name_of(const Message& message) {
  const FieldDescriptor* name = message.GetDescriptor()->FindFieldByName("name");
  const bool known =
      name != nullptr && name->cpp_type() == FieldDescriptor::CPPTYPE_STRING && !name->is_repeated();
  return known ? message.GetReflection()->GetString(message, name) : std::string();
}

/// Finds the numbers of a scene that are none.
class Search {
 public:
  explicit Search(std::size_t most) : most_(most) {}

  void look_into(const Message& message) {
    const auto* reflection = message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    reflection->ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
      switch (field->cpp_type()) {
        case FieldDescriptor::CPPTYPE_FLOAT:
          look_at<float>(message, field);
          break;
        case FieldDescriptor::CPPTYPE_DOUBLE:
          look_at<double>(message, field);
          break;
        case FieldDescriptor::CPPTYPE_MESSAGE:
          look_into_field(message, field);
          break;
        default:
          break;
      }
    }
  }

  std::vector<BadNumber> found() && { return std::move(found_); }

 private:
  void look_into_field(const Message& message, const FieldDescriptor* field) {
    const auto* reflection = message.GetReflection();
    const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
    for (int i = 0; i < count && found_.size() < most_; ++i) {
      const Message& child = field->is_repeated() ? reflection->GetRepeatedMessage(message, field, i)
                                                  : reflection->GetMessage(message, field);
      path_.emplace_back(field, field->is_repeated() ? i : -1);
      messages_.push_back(&child);
      look_into(child);
      messages_.pop_back();
      path_.pop_back();
    }
  }

  template <typename T>
  void look_at(const Message& message, const FieldDescriptor* field) {
    const auto* reflection = message.GetReflection();
    if (!field->is_repeated()) {
      if constexpr (std::is_same_v<T, float>) check(reflection->GetFloat(message, field), field, -1);
      if constexpr (std::is_same_v<T, double>) check(reflection->GetDouble(message, field), field, -1);
      return;
    }
    int index = 0;
    for (const T value : reflection->GetRepeatedFieldRef<T>(message, field)) check(value, field, index++);
  }

  void check(double value, const FieldDescriptor* field, int index) {
    if (is_scene_number(value) || found_.size() >= most_) return;
    BadNumber& bad = found_.emplace_back(BadNumber{.path = path_, .element = {}, .value = value});
    bad.path.emplace_back(field, index);
    for (auto at = messages_.rbegin(); at != messages_.rend() && bad.element.empty(); ++at)
      bad.element = name_of(**at);
  }

  const std::size_t most_;
  std::vector<std::pair<const FieldDescriptor*, int>> path_;
  std::vector<const Message*> messages_;  // messages that the path leads through
  std::vector<BadNumber> found_;
};

/// The first value of a spectrum that is no index of refraction, else any of them.
float worst_index(const v1::Spectrum& spectrum) {
  if (spectrum.has_rgb()) return spectrum.rgb().g();  // the index of all bands
  if (spectrum.kind_case() == v1::Spectrum::kConstant) return spectrum.constant();
  float eta = 1;
  for (const float value : spectrum.sampled().values()) {
    eta = value;
    if (!check_index(eta).ok()) break;
  }
  return eta;
}

}  // namespace

absl::Status check_index(float eta) {
  if (eta >= kLeastIndex && eta <= kLargestIndex) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("an index of refraction of ", eta, " is not between ",
                                                 kLeastIndex, " and ", kLargestIndex));
}

std::string index_fault(const v1::Material& material) {
  const auto* reflection = material.GetReflection();
  const FieldDescriptor* const kind =
      reflection->GetOneofFieldDescriptor(material, material.GetDescriptor()->FindOneofByName("kind"));
  if (kind == nullptr) return "";
  const Message& model = reflection->GetMessage(material, kind);
  std::vector<const FieldDescriptor*> fields;
  model.GetReflection()->ListFields(model, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->name() != "eta" && field->name() != "ior") continue;
    absl::Status status;
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT) {
      status = check_index(model.GetReflection()->GetFloat(model, field));
    } else if (field->message_type() == v1::Spectrum::descriptor()) {
      const auto& spectrum =
          static_cast<const v1::Spectrum&>(model.GetReflection()->GetMessage(model, field));
      if (spectrum.kind_case() != v1::Spectrum::KIND_NOT_SET) status = check_index(worst_index(spectrum));
    }
    if (!status.ok()) return std::string(status.message());
  }
  return "";
}

std::string BadNumber::to_string() const {
  std::string text;
  for (const auto& [field, index] : path) {
    absl::StrAppend(&text, text.empty() ? "" : ".", std::string(field->name()));
    if (index >= 0) absl::StrAppend(&text, "[", index, "]");
  }
  if (!element.empty()) absl::StrAppend(&text, " (", element, ")");
  if (!std::isfinite(value)) return absl::StrCat(text, ": ", value, " is not finite");
  return absl::StrCat(text, ": ", value, " is beyond ", kLargestSceneNumber,
                      ", the largest magnitude of a number of a scene");
}

std::vector<BadNumber> find_bad_numbers(const v1::Scene& scene, std::size_t most) {
  Search search{most};
  search.look_into(scene);
  return std::move(search).found();
}

absl::Status check_scene_numbers(const v1::Scene& scene) {
  const std::vector<BadNumber> bad = find_bad_numbers(scene, 1);
  return bad.empty() ? absl::OkStatus() : absl::InvalidArgumentError(bad.front().to_string());
}

}  // namespace tessera::wire
