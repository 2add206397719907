#include "render/scene/values/fault_list.h"

#include <string_view>

#include "absl/strings/str_cat.h"
#include "render/scene/values/located.h"

namespace tessera::render {

bool FaultList::add(const google::protobuf::Message& element, const std::string& place,
                    const absl::Status& status, int field) {
  if (status.ok()) return true;
  if (full() || status == fault_is_told()) return false;
  std::string message{status.message()};
  if (const std::string start = absl::StrCat(place, ": "); !place.empty() && message.starts_with(start))
    message.erase(0, start.size());
  if (found_.empty()) {
    first_ = absl::Status(status.code(), message);
    if (!place.empty()) first_ = located(first_, place);
  }
  found_.push_back({&element, place, std::move(message), field});
  return false;
}

absl::Status fault_is_told() {
  return absl::FailedPreconditionError("an element that it refers to is at fault");
}

}  // namespace tessera::render
