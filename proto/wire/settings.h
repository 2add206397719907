// The settings of a renderer as fields of RenderSettings and of the messages in it, found by reflection: what
// is told of each stands in settings.proto.
#pragma once

#include <google/protobuf/message.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/setting.pb.h"

namespace tessera::wire {

using FieldType = google::protobuf::FieldDescriptor;

/// One setting: "max-depth", or "mlt.step" of those that one algorithm alone has.
struct SettingField {
  std::string name;
  const FieldType* group =
      nullptr;  // the field of RenderSettings that holds it; null: RenderSettings has it itself
  const FieldType* field = nullptr;

  const v1::Setting& traits() const;
};

/// All of them, in the order of declaration.
const std::vector<SettingField>& settings();

/// Sets the setting to what `text` says: a number; "on" or "off"; for an enum a word (enum_words.h).
/// InvalidArgument, with what was expected, where it says no such thing.
absl::Status set_setting(const SettingField& setting, const std::string& text, v1::RenderSettings& settings);

/// "512M", "8G": bytes, by powers of 1024. InvalidArgument, with what was expected, otherwise.
absl::StatusOr<std::uint64_t> parse_bytes(const std::string& text);

/// The number within the bounds of the setting of that name, which must exist, that is nearest to `value`:
/// for readers of foreign files.
double within_bounds(std::string_view name, double value);

/// Gives fields of `message`, RenderSettings or one of those in it, that say nothing their usual values; not
/// those of messages in it.
void fill_in_usual(google::protobuf::Message& message);

/// The field of RenderSettings or Algorithms, as `type` says, with the settings that the algorithm alone has;
/// null where it has none.
const FieldType* own_settings(const google::protobuf::Descriptor& type, const std::string& integrator);

/// The number in a field, of an enum its value's, of a switch 0 or 1; 0 for fields of other types.
double number_in(const google::protobuf::Message& message, const FieldType& field);

/// InvalidArgument, naming the algorithm that has them, where `message`, RenderSettings or Algorithms, has
/// settings of another algorithm than `integrator`.
absl::Status check_owner(const google::protobuf::Message& message, const std::string& integrator);

/// InvalidArgument, by name, where a field of `part` that has the name of a setting is out of its bounds, or
/// where one in a message of settings lacks a value that it usually has.
absl::Status check_values(const google::protobuf::Message& part);

}  // namespace tessera::wire
